//! Bézier curves, key frames, the clock (frame -> shutter -> scene time), sampled transforms.
