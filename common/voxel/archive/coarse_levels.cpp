#include "common/voxel/archive/coarse_levels.hpp"

#include <map>
#include <set>
#include <utility>

#include "common/thread/in_order.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel::archive {
namespace {

MadeBox read_back(const ArchiveWriter& writer, const Entry& entry) {
    const auto frame = writer.make_frame(entry);
    if (entry.kind == Kind::kHole)
        return {nullptr, std::string(reinterpret_cast<const char*>(frame.data()), frame.size())};
    return {decompress_box(frame, to_string(to_key(entry.key))), std::nullopt};
}

void add_level(ArchiveWriter& writer, int level, int threads, const KeptRecord& kept) {
    writer.flush();
    std::map<BoxKey, Entry> below;
    std::set<BoxKey> parents;
    for (const Entry& e : writer.coarse_entries()) {
        const BoxKey key = to_key(e.key);
        if (key.level != level - 1)
            continue;
        below.emplace(key, e);
        parents.insert(Pyramid::parent(key));
    }
    const std::vector<BoxKey> keys(parents.begin(), parents.end());
    thread::in_order(
        keys.size(), threads,
        [&](std::size_t i) {
            if (auto record = kept ? kept(keys[i]) : std::nullopt)
                return std::move(*record);
            const auto child = [&](const BoxKey& key) {
                const auto found = below.find(key);
                return found == below.end() ? MadeBox{} : read_back(writer, found->second);
            };
            return make_record(keys[i], coarse_box(keys[i], Pyramid::children(keys[i], child)));
        },
        [&](std::size_t, const MadeRecord& record) {
            if (!record.frame.empty())
                writer.add(record.key, record.kind, record.frame);
        });
}

}  // namespace

MadeRecord make_record(const BoxKey& key, const MadeBox& made) {
    if (made.hole) {
        const std::string reason = made.hole->empty() ? "unknown" : *made.hole;
        const auto bytes = std::as_bytes(std::span(reason));
        return {key, Kind::kHole, {bytes.begin(), bytes.end()}};
    }
    if (!made.box)
        return {key, Kind::kBox, {}};
    return {key, Kind::kBox, compress(*made.box, kZstdLevel)};
}

MadeBox coarse_box(const BoxKey& key, const Pyramid::Children<MadeBox>& children) {
    Pyramid::Children<std::shared_ptr<const Box>> boxes;
    for (std::size_t i = 0; i < 8; ++i) {
        if (children[i].hole)
            return {nullptr, children[i].hole};
        boxes[i] = children[i].box;
    }
    return {downsample(key, boxes), std::nullopt};
}

void add_levels_above(ArchiveWriter& writer, int below, int levels, int threads,
                      const KeptRecord& kept) {
    for (int level = below + 1; level < levels; ++level)
        add_level(writer, level, threads, kept);
}

}  // namespace terravox::voxel::archive
