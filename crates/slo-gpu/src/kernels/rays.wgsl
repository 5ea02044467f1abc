// What all kernels share: rays, the triangle test, and when a ray crosses a plane. The host puts this
// file before that of a structure.
//
// The names and the order of all operations are those of the crate slo-accel: `Line` of
// structure/study/ray.rs, `ShearedRay` and `intersect` of primitives/triangle. WGSL promises few bits: a
// device may fuse `a * b + c` or compute it in two steps, and it divides with an error. Here neither
// changes a result:
//
// - Where the CPU fuses numbers of 24 bits, the product is taken in 53 bits, which hold it exactly:
//   whether the device fuses the sum makes no difference (`fused`).
// - Quotients of 24 bits are taken in 53 bits and rounded, which gives the rounded quotient even if the
//   last bits of 53 are wrong.
// - Crossings of planes are in 53 bits on the CPU too, and wide by millions of their last bits.
//
// No operation chains two constants, since compilers join them. No number is infinite but the end of a
// ray.

// A ray, prepared by the CPU.
struct Ray {
    origin_x: f32,
    origin_y: f32,
    origin_z: f32,
    t_max: f32,
    direction_x: f32,
    direction_y: f32,
    direction_z: f32,
    // The axis of the largest component of the direction.
    main_axis: u32,
    // In the order x, y, z of the sheared axes.
    shear_x: f32,
    shear_y: f32,
    shear_z: f32,
    unused: u32,
}

// What becomes of a ray: 48 bytes, 12 words.
struct Answer {
    t: f32,
    u: f32,
    v: f32,
    object: u32,
    steps: u32,
    boxes: u32,
    tests: u32,
    leaves: u32,
    empty_leaves: u32,
    restarts: u32,
    iterations: u32,
    // Why the CPU must trace the ray again; 0: it need not.
    doubts: u32,
}

// What holds for a dispatch: 160 bytes. Scalars only, so that no alignment comes in between.
struct Query {
    // Stands for an infinite time.
    forever: f64,
    // Four times the smallest f32 above 0.
    least_time: f64,
    // slo_accel::triangle::POSITION_ERROR.
    position_error: f64,
    // 1, which no compiler knows.
    one: f64,
    // The box of the structure.
    min_x: f64,
    min_y: f64,
    min_z: f64,
    max_x: f64,
    max_y: f64,
    max_z: f64,
    // Grid: lengths of the sides of a cell.
    side_x: f64,
    side_y: f64,
    side_z: f64,
    // A ray that does not arrive at the end of a loop in this many rounds is left to the CPU.
    most_iterations: u32,
    // Number of rays.
    rays: u32,
    // 1: any hit is enough.
    any: u32,
    // Number of nodes; grid: of references.
    nodes: u32,
    // Grid: numbers of cells.
    cells_x: u32,
    cells_y: u32,
    cells_z: u32,
    // Kd-tree: entries of the stack, and whether rays start again at the deepest node that will do.
    entries: u32,
    pushes_down: u32,
    unused_a: u32,
    unused_b: u32,
    unused_c: u32,
    unused_d: u32,
    unused_e: u32,
}

@group(0) @binding(0) var<uniform> query: Query;
@group(0) @binding(1) var<storage, read> rays: array<Ray>;
@group(0) @binding(2) var<storage, read_write> answers: array<Answer>;
// The corners of each object, x, y and z of one after the other.
@group(0) @binding(3) var<storage, read> triangles: array<f32>;
@group(0) @binding(4) var<storage, read> references: array<u32>;

const NO_HIT: u32 = 0xffffffffu;
// The sum of a product may lie just between two numbers of 24 bits.
const DOUBT_ROUNDING: u32 = 1u;
// The traversal is too long, or has no room left.
const DOUBT_LENGTH: u32 = 2u;
// 2^-120 and 2^-12, as in primitives/triangle.
const MIN_DETERMINANT: f32 = 0x1p-120f;
const SURE_OF_SIGN: f32 = 0x1p-12f;

// ---- The ray

// Line: in the axes of space, in 53 bits.
var<private> origin: vec3<f64>;
var<private> direction: vec3<f64>;
var<private> slack: vec3<f64>;
var<private> error: f64;
var<private> falls: vec3<bool>;
// The ray runs along the planes of an axis.
var<private> along: vec3<bool>;

// ShearedRay: in the order x, y, z of the sheared axes.
var<private> axes: vec3<u32>;
var<private> sheared_origin: vec3<f32>;
var<private> shear: vec3<f32>;

// ---- What it has found

// The largest t that still counts. Negative: no more does.
var<private> t_max: f32;
var<private> best: u32 = NO_HIT;
var<private> best_t: f32;
var<private> best_area_b: f32;
var<private> best_area_c: f32;
var<private> best_determinant: f32;

var<private> steps: u32;
var<private> boxes: u32;
var<private> tests: u32;
var<private> leaves: u32;
var<private> empty_leaves: u32;
var<private> restarts: u32;
var<private> iterations: u32;
var<private> doubts: u32;

// References of the leaf that is being tested.
var<private> next: u32;
var<private> end: u32;

// Prepares ray `i`: Line::new.
fn begin(i: u32) {
    let ray = rays[i];
    let place = vec3<f32>(ray.origin_x, ray.origin_y, ray.origin_z);
    let toward = vec3<f32>(ray.direction_x, ray.direction_y, ray.direction_z);
    t_max = ray.t_max;

    let z = ray.main_axis;
    axes = vec3<u32>((z + 1u) % 3u, (z + 2u) % 3u, z);
    sheared_origin = vec3<f32>(place[axes.x], place[axes.y], place[axes.z]);
    shear = vec3<f32>(ray.shear_x, ray.shear_y, ray.shear_z);

    origin = vec3<f64>(f64(place.x), f64(place.y), f64(place.z));
    falls = toward < vec3<f32>(0.0, 0.0, 0.0);
    along = toward == vec3<f32>(0.0, 0.0, 0.0);
    // No division by 0: the results are not used.
    let divisor = select(toward, vec3<f32>(1.0, 1.0, 1.0), along);
    direction = vec3<f64>(f64(divisor.x), f64(divisor.y), f64(divisor.z));
    let low = abs(vec3<f64>(query.min_x, query.min_y, query.min_z) - origin);
    let high = abs(vec3<f64>(query.max_x, query.max_y, query.max_z) - origin);
    let far = max(low, high);
    error = query.position_error * max(max(far.x, far.y), far.z);
    let time = query.least_time;
    let by = abs(direction);
    slack = vec3<f64>(error / by.x + time, error / by.y + time, error / by.z + time);
}

// Line::crossing: the early and the late time at which the ray crosses a plane.
fn crossing(axis: u32, plane: f64) -> vec2<f64> {
    let distance = plane - origin[axis];
    if along[axis] {
        let early = select(-query.forever, query.forever, distance > error);
        let late = select(query.forever, -query.forever, distance < -error);
        return vec2<f64>(early, late);
    }
    let t = distance / direction[axis];
    return vec2<f64>(t - slack[axis], t + slack[axis]);
}

// The end of the ray in 53 bits.
fn wide_end() -> f64 {
    return select(f64(t_max), query.forever, t_max > 3.4028234e38f);
}

// Line::span: from when to when the ray may find hits in a box; `x > y` if it cannot.
fn span(low: vec3<f64>, high: vec3<f64>) -> vec2<f64> {
    let entry = select(low, high, falls);
    let exit = select(high, low, falls);
    let near_x = crossing(0u, entry.x).x;
    let near_y = crossing(1u, entry.y).x;
    let near_z = crossing(2u, entry.z).x;
    let far_x = crossing(0u, exit.x).y;
    let far_y = crossing(1u, exit.y).y;
    let far_z = crossing(2u, exit.z).y;
    let zero = f64(0.0f);
    let near = max(max(max(zero, near_x), near_y), near_z);
    let far = min(min(min(wide_end(), far_x), far_y), far_z);
    return vec2<f64>(near, far);
}

// Whether hits from a time on still count.
fn reaches(t: f64) -> bool {
    return max(t, f64(0.0f)) <= wide_end();
}

// One round of the main loop. A software device ends loops silently after 65,535 rounds, all loops of
// a kernel together: before that, the ray is left to the CPU. Every kernel has one loop, in whose rounds
// each ray takes one step or tests one object, so that no ray waits for another one's inner loop.
fn another_round() -> bool {
    iterations += 1u;
    if iterations > query.most_iterations {
        doubts |= DOUBT_LENGTH;
    }
    return doubts == 0u;
}

// Begins the tests of a leaf or a cell.
fn enter_leaf(start: u32, count: u32) {
    leaves += 1u;
    empty_leaves += select(0u, 1u, count == 0u);
    next = start;
    end = start + count;
}

// Tests the next object of a leaf.
fn test_next() {
    tests += 1u;
    test_object(references[next]);
    next += 1u;
    if t_max < 0.0 {
        next = end;
    }
}

// Writes what has become of ray `i`.
fn finish(i: u32) {
    var answer: Answer;
    answer.object = best;
    answer.t = best_t;
    if best != NO_HIT {
        answer.u = quotient(best_area_b, best_determinant);
        answer.v = quotient(best_area_c, best_determinant);
    }
    answer.steps = steps;
    answer.boxes = boxes;
    answer.tests = tests;
    answer.leaves = leaves;
    answer.empty_leaves = empty_leaves;
    answer.restarts = restarts;
    answer.iterations = iterations;
    answer.doubts = doubts;
    answers[i] = answer;
}

// ---- The triangle test

// `a b + c`, rounded once to 24 bits.
//
// The product is exact in 53 bits. The sum is rounded to 53 bits and then to 24. That is once too often
// only if the first rounding is not exact and ends just between two numbers of 24 bits, a power of 2 away
// from both.
fn fused(a: f32, b: f32, c: f32) -> f32 {
    let sum = f64(a) * f64(b) + f64(c);
    let rounded = f32(sum);
    let rest = bitcast<u32>(f32(abs(sum - f64(rounded))));
    let exponent = (bitcast<u32>(rounded) >> 23u) & 0xffu;
    let is_between = (rest & 0x7fffffu) == 0u && exponent <= (rest >> 23u) + 25u;
    // Near the smallest numbers there are fewer bits.
    if rest != 0u && (is_between || exponent < 30u) && !is_exact(f64(a) * f64(b), f64(c)) {
        doubts |= DOUBT_ROUNDING;
    }
    return rounded;
}

// Whether a sum is not rounded: Knuth's test. Compilers make `a` of `(a + b) - b`, unless the two are not
// known to be the same.
fn is_exact(a: f64, b: f64) -> bool {
    let sum = a * query.one + b * query.one;
    return sum - a == b && sum - b == a;
}

// `a / b`, rounded once to 24 bits.
fn quotient(a: f32, b: f32) -> f32 {
    return f32(f64(a) / f64(b));
}

// `a b - c d` to 1.5 units in the last place: its sign is right.
fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let cd = c * d;
    // The error of a product is a number of 24 bits.
    let error_of_cd = f32(f64(cd) - f64(c) * f64(d));
    return fused(a, b, -cd) + error_of_cd;
}

// A corner in sheared coordinates, relative to the origin of the ray.
fn corner(at: u32) -> vec3<f32> {
    let x = triangles[at + axes.x] - sheared_origin.x;
    let y = triangles[at + axes.y] - sheared_origin.y;
    let z = triangles[at + axes.z] - sheared_origin.z;
    return vec3<f32>(fused(-shear.x, z, x), fused(-shear.y, z, y), z);
}

// Tests an object. Of hits at the same distance, that of the lowest number counts.
fn test_object(object: u32) {
    if t_max < 0.0 {
        return;
    }
    let at = object * 9u;
    let a = corner(at);
    let b = corner(at + 3u);
    let c = corner(at + 6u);
    let area_a = difference_of_products(c.x, b.y, c.y, b.x);
    let area_b = difference_of_products(a.x, c.y, a.y, c.x);
    let area_c = difference_of_products(b.x, a.y, b.y, a.x);
    let positive = area_a >= 0.0 && area_b >= 0.0 && area_c >= 0.0;
    let negative = area_a <= 0.0 && area_b <= 0.0 && area_c <= 0.0;
    let determinant = (area_a + area_b) + area_c;
    if !(positive || negative) || abs(determinant) < MIN_DETERMINANT {
        return;
    }
    let z = fused(area_c, c.z, fused(area_b, b.z, area_a * a.z));
    let t = quotient(z, determinant) * shear.z;
    var limit = t_max;
    if object < best && best != NO_HIT {
        limit = bitcast<f32>(bitcast<u32>(t_max) + 1u);
    }
    if !(t > 0.0 && t < limit) {
        return;
    }
    let reach = max(max(abs(a.z), abs(b.z)), abs(c.z));
    let is_doubtful = abs(z) <= abs(determinant) * reach * SURE_OF_SIGN;
    if is_doubtful && !lies_ahead(at, determinant < 0.0) {
        return;
    }
    best = object;
    best_t = t;
    best_area_b = area_b;
    best_area_c = area_c;
    best_determinant = determinant;
    t_max = select(t, -1.0, query.any != 0u);
}

fn wide_corner(at: u32) -> vec3<f64> {
    return vec3<f64>(
        f64(triangles[at + axes.x]),
        f64(triangles[at + axes.y]),
        f64(triangles[at + axes.z]),
    );
}

// Whether a ray that hits a triangle starts before its plane: not on it, and not behind.
fn lies_ahead(at: u32, is_negative: bool) -> bool {
    let a = wide_corner(at);
    let place = vec3<f64>(f64(sheared_origin.x), f64(sheared_origin.y), f64(sheared_origin.z));
    let e = wide_corner(at + 3u) - a;
    let f = wide_corner(at + 6u) - a;
    let p = a - place;
    let x = (e.y * f.z - e.z * f.y) * p.x;
    let y = (e.z * f.x - e.x * f.z) * p.y;
    let z = (e.x * f.y - e.y * f.x) * p.z;
    let volume = (x + y) + z;
    let zero = f64(0.0f);
    return volume != zero && (((volume < zero) != is_negative) != (shear.z < 0.0));
}
