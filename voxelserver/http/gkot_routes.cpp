#include "voxelserver/http/gkot_routes.hpp"

#include "voxelserver/gkot/gkot_box.hpp"
#include "voxelserver/gkot/gkot_origin.hpp"
#include "voxelserver/gkot/gkot_request.hpp"

namespace terravox::http {
namespace {

// One reply may take 130 MiB while it is made: few at a time, whatever the other limits are.
constexpr int kAtOnce = 2, kInLine = 32;
boxes::Gate& gate() {
    static boxes::Gate one(kAtOnce, kInLine);
    return one;
}

gkot::FetchBox fetch_from(Service& service) {
    return [&service](const voxel::BoxKey& key) -> std::shared_ptr<const voxel::Box> {
        const voxel::ColumnExtent column = service.world.column(key.level, key.bx, key.bz);
        if (key.by < column.by_begin || key.by >= column.by_end) return nullptr;
        return boxes::BoxCache::unpacked(*service.boxes.get(key), key);
    };
}

// What the person asked wrongly is their affair, what the world throws later is ours.
template <class Parse, class Work>
Response answer(const Parse& parse, const Work& work) {
    decltype(parse()) request;
    try {
        request = parse();
    } catch (const UsageError& e) {
        return problem(400, e.what());
    }
    const boxes::Gate::Pass pass(gate());
    return work(request);
}

}  // namespace

Response answer_gkot_box(Service& service, const Asked& asked) {
    return answer([&] { return gkot::parse_box_request(asked.request.query); },
                  [&](const gkot::BoxRequest& request) {
                      return reply(200, "application/octet-stream", gkot::box_reply(service.world.info(), request, fetch_from(service))).add("Cache-Control", "no-store");
                  });
}

Response answer_gkot_origin(Service& service, const Asked& asked) {
    return answer([&] { return gkot::parse_origin_request(asked.request.query); },
                  [&](const gkot::OriginRequest& request) {
                      return reply(200, "application/json", gkot::to_json(gkot::find_origin(service.world.info(), request, fetch_from(service)))).add("Cache-Control", "no-store");
                  });
}

}  // namespace terravox::http
