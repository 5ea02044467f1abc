//! Table 6.1 of the thesis on distributed ray tracing: the time of 100 million operations on vectors.
//!
//! A program of one file for `distributed.py`, which compiles it by
//! `rustc -O -C no-vectorize-loops -C no-vectorize-slp`, so that only what uses SSE here is done by SSE. Prints lines:
//! a name and seconds, the shortest of three runs. Runs on x86-64 only.

use std::arch::x86_64::*;
use std::hint::black_box;
use std::time::Instant;

const OPERATIONS: u32 = 100_000_000;
/// Vectors that are worked on in turn, so that no operation waits for the one before.
const VECTORS: usize = 8;

fn time<T: Copy>(name: &str, vector: T, operation: impl Fn(T) -> T) {
    let run = || {
        let mut vectors = black_box([vector; VECTORS]);
        let begin = Instant::now();
        for _ in 0..OPERATIONS / VECTORS as u32 {
            for vector in &mut vectors {
                *vector = operation(*vector);
            }
            // The vectors are in memory between operations, as those of a ray tracer are.
            black_box(&mut vectors);
        }
        begin.elapsed().as_secs_f64()
    };
    println!("{name} {:.4}", (0..3).map(|_| run()).fold(f64::INFINITY, f64::min));
}

/// The square of the length, in all four places.
#[target_feature(enable = "sse2")]
fn square(v: __m128) -> __m128 {
    let squares = _mm_mul_ps(v, v);
    let pairs = _mm_add_ps(squares, _mm_shuffle_ps::<0b10_11_00_01>(squares, squares));
    _mm_add_ps(pairs, _mm_shuffle_ps::<0b01_00_11_10>(pairs, pairs))
}

fn main() {
    // SAFETY: all processors of x86-64 have SSE2.
    unsafe { measure() }
}

#[target_feature(enable = "sse2")]
fn measure() {
    let scalar = [1.0_f32, 2.0, 3.0, 0.0];
    let vector = _mm_setr_ps(1.0, 2.0, 3.0, 0.0);

    time("normalise_fpu", scalar, |v| {
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        [v[0] / length, v[1] / length, v[2] / length, 0.0]
    });
    time("normalise_sse", vector, |v| _mm_div_ps(v, _mm_sqrt_ps(square(v))));
    time("normalise_rcp", vector, |v| _mm_mul_ps(v, _mm_rsqrt_ps(square(v))));
    time("normalise_newton", vector, |v| {
        // One step of Newton's method: r (3 - s r^2) / 2.
        let square = square(v);
        let root = _mm_rsqrt_ps(square);
        let error = _mm_sub_ps(_mm_set1_ps(3.0), _mm_mul_ps(square, _mm_mul_ps(root, root)));
        _mm_mul_ps(v, _mm_mul_ps(_mm_mul_ps(_mm_set1_ps(0.5), root), error))
    });
    time("add_fpu", scalar, |v| [v[0] + 1e-7, v[1] + 1e-7, v[2] + 1e-7, v[3] + 1e-7]);
    let step = _mm_set1_ps(1e-7);
    time("add_sse", vector, |v| _mm_add_ps(v, step));
}
