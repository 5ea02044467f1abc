// Embree's answer to crates/slo-accel/examples/trace_rays.rs: the same files, the same lines of JSON.
//
//   c++ -O3 -march=native scripts/embree/trace_rays.cpp -o trace_rays_embree -lembree3
//   trace_rays_embree MESH.tri RAYS.rays KERNEL [REPEAT [COPIES]]
//
// KERNEL is 1 (single rays), 8 or 16 (packets of so many). COPIES is a file as for --copies. One thread, robust mode off, the build
// quality that Embree takes by itself. Needs Debian's libembree-dev, for measuring only.

#include <embree3/rtcore.h>

#include <chrono>
#include <ctime>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace {

constexpr unsigned kCoherentSets = 3;

struct Ray {
    float origin[3], direction[3], t_max, padding;
};

struct RaySet {
    bool any_hit;
    std::vector<Ray> rays;
};

double now() {
    using clock = std::chrono::steady_clock;
    return std::chrono::duration<double>(clock::now().time_since_epoch()).count();
}

// Seconds that a processor has worked for this program.
double worked() {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return time.tv_sec + 1e-9 * time.tv_nsec;
}

std::vector<char> read(const char* path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        std::fprintf(stderr, "error: can't read %s\n", path);
        std::exit(1);
    }
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

uint32_t word(const std::vector<char>& bytes, size_t at) {
    uint32_t value = 0;
    if (at + sizeof value > bytes.size()) {
        std::fprintf(stderr, "error: a file ends too early\n");
        std::exit(1);
    }
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

std::vector<RaySet> read_rays(const char* path) {
    const std::vector<char> bytes = read(path);
    std::vector<RaySet> sets(word(bytes, 0));
    size_t at = 4;
    for (RaySet& set : sets) {
        const size_t count = word(bytes, at);
        set.any_hit = word(bytes, at + 4) == 1;
        at += 8;
        set.rays.resize(count);
        if (at + count * 40 > bytes.size()) word(bytes, bytes.size());
        std::memcpy(set.rays.data(), bytes.data() + at, count * sizeof(Ray));
        at += count * (sizeof(Ray) + 8);
    }
    return sets;
}

// One lane of a ray or a packet of any width.
template <class R>
void fill(R& ray, size_t lane, const Ray& from) {
    auto set = [lane](auto& field, auto value) {
        if constexpr (std::is_array_v<std::remove_reference_t<decltype(field)>>) field[lane] = value;
        else field = value;
    };
    set(ray.org_x, from.origin[0]);
    set(ray.org_y, from.origin[1]);
    set(ray.org_z, from.origin[2]);
    set(ray.dir_x, from.direction[0]);
    set(ray.dir_y, from.direction[1]);
    set(ray.dir_z, from.direction[2]);
    set(ray.tnear, 0.0f);
    set(ray.tfar, from.t_max);
    set(ray.time, 0.0f);
    set(ray.mask, ~0u);
    set(ray.id, 0u);
    set(ray.flags, 0u);
}

template <size_t N, class RayHit, class Intersect, class Occluded>
void trace(RTCScene scene, const RaySet& set, bool coherent, Intersect intersect, Occluded occluded) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[16];
    for (size_t i = 0; i < set.rays.size(); i += N) {
        RayHit packet;
        for (size_t lane = 0; lane < N; ++lane) {
            const bool exists = i + lane < set.rays.size();
            valid[lane] = exists ? -1 : 0;
            fill(packet.ray, lane, set.rays[exists ? i + lane : i]);
            if constexpr (N == 1) packet.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            else packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        }
        if (set.any_hit) occluded(valid, scene, &context, packet);
        else intersect(valid, scene, &context, packet);
    }
}

void trace_all(RTCScene scene, const RaySet& set, int kernel, bool coherent) {
    if (kernel == 16) {
        trace<16, RTCRayHit16>(scene, set, coherent,
            [](auto v, auto s, auto c, auto& p) { rtcIntersect16(v, s, c, &p); },
            [](auto v, auto s, auto c, auto& p) { rtcOccluded16(v, s, c, &p.ray); });
    } else if (kernel == 8) {
        trace<8, RTCRayHit8>(scene, set, coherent,
            [](auto v, auto s, auto c, auto& p) { rtcIntersect8(v, s, c, &p); },
            [](auto v, auto s, auto c, auto& p) { rtcOccluded8(v, s, c, &p.ray); });
    } else {
        trace<1, RTCRayHit>(scene, set, coherent,
            [](auto, auto s, auto c, auto& p) { rtcIntersect1(s, c, &p); },
            [](auto, auto s, auto c, auto& p) { rtcOccluded1(s, c, &p.ray); });
    }
}

RTCScene build(RTCDevice device, const char* path) {
    const std::vector<char> bytes = read(path);
    const uint32_t count = word(bytes, 0);
    if (bytes.size() < 4 + size_t(count) * 36) word(bytes, bytes.size());
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, size_t(count) * 3);
    std::memcpy(vertices, bytes.data() + 4, size_t(count) * 36);
    auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
    for (uint32_t i = 0; i < 3 * count; ++i) indices[i] = i;
    rtcCommitGeometry(mesh);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    const double start = now();
    rtcCommitScene(scene);
    std::printf("{\"build_s\":%.4f}\n", now() - start);
    return scene;
}

// The scene at many places: a count, then the rows of object to world for each.
RTCScene place(RTCDevice device, RTCScene scene, const char* path) {
    const std::vector<char> bytes = read(path);
    const uint32_t count = word(bytes, 0);
    if (bytes.size() < 4 + size_t(count) * 48) word(bytes, bytes.size());
    const double start = now();
    RTCScene all = rtcNewScene(device);
    for (uint32_t i = 0; i < count; ++i) {
        float rows[12];
        std::memcpy(rows, bytes.data() + 4 + size_t(i) * 48, sizeof rows);
        RTCGeometry copy = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(copy, scene);
        rtcSetGeometryTransform(copy, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
        rtcCommitGeometry(copy);
        rtcAttachGeometry(all, copy);
        rtcReleaseGeometry(copy);
    }
    rtcCommitScene(all);
    std::printf("{\"copies_build_s\":%.4f}\n", now() - start);
    return all;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: trace_rays_embree MESH.tri RAYS.rays 1|8|16 [REPEAT [COPIES]]\n");
        return 2;
    }
    const int kernel = std::atoi(argv[3]);
    const int repeat = argc > 4 ? std::atoi(argv[4]) : 5;
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = build(device, argv[1]);
    if (argc > 5) scene = place(device, scene, argv[5]);
    const std::vector<RaySet> sets = read_rays(argv[2]);
    for (size_t i = 0; i < sets.size(); ++i) {
        double best = std::numeric_limits<double>::infinity(), best_worked = best;
        // Embree 3.13.5 does not come back from packets of 16 shadow rays among copies.
        const int width = kernel == 16 && sets[i].any_hit && argc > 5 ? 8 : kernel;
        // The flag may help or hurt rays that are alike; the better one counts.
        for (int coherent = 0; coherent <= (i < kCoherentSets ? 1 : 0); ++coherent) {
            for (int pass = 0; pass <= repeat; ++pass) {
                const double start = now(), work = worked();
                trace_all(scene, sets[i], width, coherent == 1);
                if (pass > 0 && now() - start < best) best = now() - start;
                if (pass > 0 && worked() - work < best_worked) best_worked = worked() - work;
            }
        }
        const double rays = sets[i].rays.size() / 1e6;
        std::printf("{\"set\":%zu,\"rays\":%zu,\"mrays_per_s\":%.3f,\"cpu_mrays_per_s\":%.3f}\n", i,
                    sets[i].rays.size(), rays / best, rays / best_worked);
        std::fflush(stdout);
    }
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}
