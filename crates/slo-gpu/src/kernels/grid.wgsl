// A uniform grid, traversed cell by cell: structure/study/grid.rs.
//
// The cells of an axis are numbered in the order in which the ray enters them: its places. On each axis
// the ray is in the places from `first`, which it may not have left, to `last`, which it may have entered;
// almost always they are the same. `leaves_at` is when it has certainly left the first, `enters_at` when
// it may enter the one after the last.

// Where the references of each cell start, and where those of the last end.
@group(0) @binding(5) var<storage, read> starts: array<u32>;

// Most rounds of the loops that find where a ray enters the grid; see `another_round`. Up to 64 rays of a
// software device may have them one after the other.
const MOST_TO_START: u32 = 80u;

var<private> first: vec3<u32>;
var<private> last: vec3<u32>;
var<private> leaves_at: vec3<f64>;
var<private> enters_at: vec3<f64>;
var<private> rounds_to_start: u32;

// The places that are still to be visited: from `begins` to `last`, x first, of which `at` is the next.
var<private> begins: vec3<u32>;
var<private> at: vec3<u32>;
var<private> has_cells: bool;

fn cells() -> vec3<u32> {
    return vec3<u32>(query.cells_x, query.cells_y, query.cells_z);
}

// Coordinate of plane `i` of an axis.
fn plane(axis: u32, i: u32) -> f64 {
    let high = vec3<f64>(query.max_x, query.max_y, query.max_z);
    if i == cells()[axis] {
        return high[axis];
    }
    let low = vec3<f64>(query.min_x, query.min_y, query.min_z);
    let side = vec3<f64>(query.side_x, query.side_y, query.side_z);
    return low[axis] + f64(i) * side[axis];
}

// When the ray may enter a place; never, if there is none.
fn enters(axis: u32, place: u32) -> f64 {
    let count = cells()[axis];
    if place >= count {
        return query.forever;
    }
    return crossing(axis, plane(axis, select(place, count - place, falls[axis]))).x;
}

// When the ray has certainly left a place.
fn leaves_place(axis: u32, place: u32) -> f64 {
    let turned = cells()[axis] - 1u - place;
    return crossing(axis, plane(axis, select(place + 1u, turned, falls[axis]))).y;
}

fn may_go_on() -> bool {
    rounds_to_start += 1u;
    return rounds_to_start <= MOST_TO_START;
}

// The cell of an axis that holds a coordinate, or the nearest one.
fn cell_of(axis: u32, x: f64) -> u32 {
    let low = vec3<f64>(query.min_x, query.min_y, query.min_z);
    let side = vec3<f64>(query.side_x, query.side_y, query.side_z);
    let most = cells()[axis] - 1u;
    let zero = f64(0.0f);
    var cell = 0u;
    // The guess may be wrong: planes decide.
    if side[axis] > zero {
        cell = u32(min(max((x - low[axis]) / side[axis], zero), f64(most)));
    }
    while cell > 0u && x < plane(axis, cell) && may_go_on() {
        cell -= 1u;
    }
    while cell < most && x >= plane(axis, cell + 1u) && may_go_on() {
        cell += 1u;
    }
    return cell;
}

// The places of an axis where the ray is when it may enter the grid.
fn start(axis: u32, near: f64) {
    let count = cells()[axis];
    var toward = direction[axis];
    if along[axis] {
        toward = f64(0.0f);
    }
    let cell = cell_of(axis, origin[axis] + near * toward);
    let guess = select(cell, count - 1u - cell, falls[axis]);
    var earliest = guess;
    var latest = guess;
    while earliest > 0u && leaves_place(axis, earliest - 1u) >= near && may_go_on() {
        earliest -= 1u;
    }
    while earliest < latest && leaves_place(axis, earliest) < near && may_go_on() {
        earliest += 1u;
    }
    while latest + 1u < count && enters(axis, latest + 1u) <= near && may_go_on() {
        latest += 1u;
    }
    first[axis] = earliest;
    last[axis] = latest;
    leaves_at[axis] = leaves_place(axis, earliest);
    enters_at[axis] = enters(axis, latest + 1u);
}

// Leaves the first place of an axis, if the ray has left it at a time and has entered the next one.
fn leave(axis: u32, now: f64) -> bool {
    let has_left = leaves_at[axis] < now && first[axis] < last[axis];
    if has_left {
        first[axis] += 1u;
        leaves_at[axis] = leaves_place(axis, first[axis]);
    }
    return has_left;
}

// Begins to visit the places from `f` to `last`.
fn visit(f: vec3<u32>) {
    begins = f;
    at = f;
    has_cells = true;
}

// Enters the next cell of those that are to be visited.
fn visit_next() {
    let count = cells();
    let cell = select(at, count - 1u - at, falls);
    let index = (cell.z * count.y + cell.y) * count.x + cell.x;
    steps += 1u;
    let start_of = starts[index];
    enter_leaf(start_of, starts[index + 1u] - start_of);
    if at.x < last.x {
        at.x += 1u;
    } else if at.y < last.y {
        at = vec3<u32>(begins.x, at.y + 1u, at.z);
    } else if at.z < last.z {
        at = vec3<u32>(begins.x, begins.y, at.z + 1u);
    } else {
        has_cells = false;
    }
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
    let is_inside = query.nodes > 0u && whole.x <= whole.y;
    if is_inside {
        start(0u, whole.x);
        start(1u, whole.x);
        start(2u, whole.x);
        if rounds_to_start > MOST_TO_START {
            doubts |= DOUBT_LENGTH;
        }
        visit(first);
    }
    // The axis whose next place is being entered, and when; 3: none.
    var entered = 3u;
    var now = f64(0.0f);
    while is_inside && another_round() {
        if next < end {
            test_next();
            continue;
        }
        if has_cells {
            visit_next();
            continue;
        }
        if entered == 3u {
            // Enters the next place of the axis that comes first.
            entered = 2u;
            if enters_at.x <= enters_at.y && enters_at.x <= enters_at.z {
                entered = 0u;
            } else if enters_at.y <= enters_at.z {
                entered = 1u;
            }
            now = enters_at[entered];
            if now > whole.y || now >= query.forever || !reaches(now) {
                break;
            }
            last[entered] += 1u;
            enters_at[entered] = enters(entered, last[entered] + 1u);
        }
        // Leaves the places that the ray has left by then, one on each axis in a round.
        let leaves_x = leave(0u, now);
        let leaves_y = leave(1u, now);
        let leaves_z = leave(2u, now);
        if !(leaves_x || leaves_y || leaves_z) {
            var f = first;
            f[entered] = last[entered];
            visit(f);
            entered = 3u;
        }
    }
    finish(id.x);
}
