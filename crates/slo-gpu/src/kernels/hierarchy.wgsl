// A hierarchy of boxes, binary: structure/study/hierarchy.rs.
//
// A visited node tests the boxes of both children. Those that the ray enters wait on a stack, the nearer
// one on top, and are dropped if a nearer hit is found before their turn.

// 32 bytes.
struct Node {
    min_x: f32,
    min_y: f32,
    min_z: f32,
    // The first child, or the first reference.
    start: u32,
    max_x: f32,
    max_y: f32,
    max_z: f32,
    // Number of references; INTERIOR: two children.
    count: u32,
}

const INTERIOR: u32 = 0xffffffffu;

@group(0) @binding(5) var<storage, read> nodes: array<Node>;

// The host writes `const STACK`: as many entries as the depth asks for.
var<private> waiting: array<u32, STACK>;
var<private> waiting_near: array<f64, STACK>;
var<private> top: u32;

fn span_of(node: u32) -> vec2<f64> {
    let n = nodes[node];
    let low = vec3<f64>(f64(n.min_x), f64(n.min_y), f64(n.min_z));
    let high = vec3<f64>(f64(n.max_x), f64(n.max_y), f64(n.max_z));
    return span(low, high);
}

fn push(node: u32, near: f64) {
    if top < STACK {
        waiting[top] = node;
        waiting_near[top] = near;
        top += 1u;
    } else {
        doubts |= DOUBT_LENGTH;
    }
}

@compute @workgroup_size(64)
fn trace(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= query.rays {
        return;
    }
    begin(id.x);
    if query.nodes > 0u {
        boxes = 1u;
        let root = span_of(0u);
        if root.x <= root.y {
            push(0u, root.x);
        }
    }
    while another_round() {
        if next < end {
            test_next();
            continue;
        }
        if top == 0u {
            break;
        }
        top -= 1u;
        let near = waiting_near[top];
        if !reaches(near) {
            continue;
        }
        steps += 1u;
        let node = nodes[waiting[top]];
        if node.count != INTERIOR {
            enter_leaf(node.start, node.count);
            continue;
        }
        boxes += 2u;
        let first = span_of(node.start);
        let second = span_of(node.start + 1u);
        let enters_first = first.x <= first.y;
        let enters_second = second.x <= second.y;
        // Of equals, the first child comes first.
        let first_is_nearer = first.x <= second.x;
        if enters_first && !first_is_nearer {
            push(node.start, first.x);
        }
        if enters_second {
            push(node.start + 1u, second.x);
        }
        if enters_first && first_is_nearer {
            push(node.start, first.x);
        }
    }
    finish(id.x);
}
