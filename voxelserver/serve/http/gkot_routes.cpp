#include "voxelserver/serve/http/route_answers.hpp"

#include "voxelserver/serve/gkot/gkot_reply.hpp"
#include "voxelserver/serve/gkot/gkot_request.hpp"

namespace terravox::http {
namespace {

// A reply takes eight bytes per voxel while it is made, up to 130 MiB: one at a time, and at most
// an eighth of the process's memory.
constexpr int kAtOnce = 1;
constexpr int kInLine = 32;
constexpr std::size_t kBytesPerVoxel = 8;
constexpr std::size_t kShare = 8;
boxes::AdmissionControl& admission() {
    static boxes::AdmissionControl one(kAtOnce, kInLine);
    return one;
}

gkot::FetchBox fetch_from(Service& service) {
    return [&service](const voxel::BoxKey& key) -> std::shared_ptr<const voxel::Box> {
        const voxel::ColumnExtent column = service.world.column(key.level, key.bx, key.bz);
        if (key.by < column.by_begin || key.by >= column.by_end)
            return nullptr;
        return boxes::BoxCache::decompress(*service.boxes.find_or_make(key), key);
    };
}

// Errors while parsing are the client's, later exceptions of the world are the server's.
template <class Parse, class Work>
Response answer(const Parse& parse, const Work& work) {
    decltype(parse()) request;
    try {
        request = parse();
    } catch (const util::UsageError& e) {
        return problem(400, e.what());
    }
    const boxes::AdmissionControl::Permit permit(admission());
    return work(request);
}

}  // namespace

Response answer_gkot_box(Service& service, const RouteRequest& call) {
    return answer(
        [&] { return gkot::parse_box_request(call.request.query); },
        [&](const gkot::BoxRequest& request) {
            const std::size_t voxels = static_cast<std::size_t>(request.sx) *
                                       static_cast<std::size_t>(request.sy) *
                                       static_cast<std::size_t>(request.sz);
            const std::size_t most = service.memory_limit_bytes / kShare / kBytesPerVoxel;
            if (most > 0 && voxels > most)
                return problem(413, "send a box: " + std::to_string(voxels) +
                                        " voxels; allowed with this server's memory: up to " +
                                        std::to_string(most));
            return reply(200, "application/octet-stream",
                         gkot::box_reply(service.world.info(), request, fetch_from(service)))
                .add("Cache-Control", "no-store");
        });
}

Response answer_gkot_origin(Service& service, const RouteRequest& call) {
    return answer([&] { return gkot::parse_origin_request(call.request.query); },
                  [&](const gkot::OriginRequest& request) {
                      return reply(200, "application/json",
                                   gkot::to_json(gkot::find_origin(service.world.info(), request,
                                                                   fetch_from(service))))
                          .add("Cache-Control", "no-store");
                  });
}

}  // namespace terravox::http
