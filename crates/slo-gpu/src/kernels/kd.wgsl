// A kd-tree with a stack of few entries, or none: structure/study/kd.rs, `follow_again`.
//
// Two bits for each level remember which far children wait, and which have been taken. The stack is a
// ring: what is put on a full one pushes out the oldest entry. If the node whose turn it is has been
// lost, the ray starts again, at the root or at the deepest node that holds all that is left.

// 8 bytes. Interior: the plane, as an f32; `4 first + axis`. Leaf: the first reference; `4 count + 3`.
@group(0) @binding(5) var<storage, read> nodes: array<vec2<u32>>;

const IS_LEAF: u32 = 3u;

// A node that is to be visited, and the span in which the ray may find hits in it.
struct Visit {
    node: u32,
    near: f64,
    far: f64,
}

// The host writes `const STACK`: the entries of the stack, or 1 if there are none.
var<private> waiting_nodes: array<u32, STACK>;
var<private> waiting_near: array<f64, STACK>;
var<private> waiting_far: array<f64, STACK>;
// Entries in use, and the place of the oldest.
var<private> held: u32;
var<private> oldest: u32;

// Levels whose second child waits, and levels whose second child has its turn: levels 0 to 31, 32 to 63.
var<private> waiting: vec2<u32>;
var<private> taken: vec2<u32>;

fn bit(level: u32) -> vec2<u32> {
    let one = 1u << (level & 31u);
    return select(vec2<u32>(one, 0u), vec2<u32>(0u, one), level >= 32u);
}

fn is_set(bits: vec2<u32>, one: vec2<u32>) -> bool {
    return ((bits.x & one.x) | (bits.y & one.y)) != 0u;
}

fn none(bits: vec2<u32>) -> bool {
    return (bits.x | bits.y) == 0u;
}

// The highest level of bits that are not 0.
fn highest(bits: vec2<u32>) -> u32 {
    if bits.y != 0u {
        return 32u + firstLeadingBit(bits.y);
    }
    return firstLeadingBit(bits.x);
}

// The bits below a single one.
fn below(one: vec2<u32>) -> vec2<u32> {
    if one.y != 0u {
        return vec2<u32>(0xffffffffu, one.y - 1u);
    }
    return vec2<u32>(one.x - 1u, 0u);
}

fn push(visit: Visit) {
    if query.entries == 0u {
        return;
    }
    if held == query.entries {
        oldest = (oldest + 1u) % query.entries;
        held -= 1u;
    }
    let place = (oldest + held) % query.entries;
    waiting_nodes[place] = visit.node;
    waiting_near[place] = visit.near;
    waiting_far[place] = visit.far;
    held += 1u;
}

@compute @workgroup_size(64)
fn trace(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= query.rays {
        return;
    }
    begin(id.x);
    let whole = span(
        vec3<f64>(query.min_x, query.min_y, query.min_z),
        vec3<f64>(query.max_x, query.max_y, query.max_z),
    );
    // Where the ray is, and the node at which it starts again, with their levels.
    var now = Visit(0u, whole.x, whole.y);
    var level = 0u;
    var again = now;
    var again_level = 0u;
    var goes_down = query.nodes > 0u && whole.x <= whole.y;
    let pushes_down = query.pushes_down != 0u;
    while another_round() {
        if next < end {
            test_next();
            continue;
        }
        if goes_down && reaches(now.near) {
            steps += 1u;
            let node = nodes[now.node];
            let axis = node.y & 3u;
            if axis == IS_LEAF {
                goes_down = false;
                enter_leaf(node.x, node.y >> 2u);
                continue;
            }
            let first = node.y >> 2u;
            let cut = crossing(axis, f64(bitcast<f32>(node.x)));
            let turn = select(0u, 1u, falls[axis]);
            let before = Visit(first + turn, now.near, min(now.far, cut.y));
            let behind = Visit(first + 1u - turn, max(now.near, cut.x), now.far);
            let enters_before = before.near <= before.far;
            let enters_behind = behind.near <= behind.far;
            let one = bit(level);
            if enters_before && enters_behind {
                if is_set(taken, one) {
                    now = behind;
                } else {
                    waiting |= one;
                    push(behind);
                    now = before;
                }
            } else if enters_before {
                now = before;
            } else if enters_behind {
                now = behind;
            } else {
                // Not so: a ray that enters a node enters a child.
                goes_down = false;
                continue;
            }
            level += 1u;
            if pushes_down && none(waiting) {
                again = now;
                again_level = level;
            }
            continue;
        }
        // The deepest second child that waits is the next.
        goes_down = false;
        if none(waiting) {
            break;
        }
        let deepest = highest(waiting);
        let one = bit(deepest);
        waiting &= ~one;
        taken = (taken & below(one)) | one;
        if held > 0u {
            held -= 1u;
            let place = (oldest + held) % query.entries;
            if !reaches(waiting_near[place]) {
                continue;
            }
            now = Visit(waiting_nodes[place], waiting_near[place], waiting_far[place]);
            level = deepest + 1u;
            if pushes_down && none(waiting) {
                again = now;
                again_level = level;
            }
        } else {
            if !reaches(again.near) {
                break;
            }
            restarts += 1u;
            now = again;
            level = again_level;
        }
        goes_down = true;
    }
    finish(id.x);
}
