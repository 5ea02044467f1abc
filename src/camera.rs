//! Camera rays: thin lens, moving through the shutter.
