#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "tests/bench/clocks.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"
#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"
#include "voxelserver/make/worlds/minecraft/world_info.hpp"

namespace terravox::bench::world_minecraft_entry {
namespace {

constexpr int kPasses = 5;
constexpr std::size_t kMemoryBytes = std::size_t{512} << 20;

struct WorldSet {
    const char *id, *path, *facts;
};
constexpr WorldSet kSets[] = {
    {"mcregion", "mc-pymclevel/PyTestWorld", "445 chunks of McRegion"},
    {"1.2", "mc-pymclevel/AnvilWorld", "583 chunks of Anvil with numeric ids"},
    {"1.18", "mc-prismarine/1.18.2", "a region of 1.18.2 with 280 chunks, of which 55 hold blocks"},
    {"1.19", "mc-fastanvil-crate/resources/1.19.4.mca",
     "a region of 1.19.4 with 676 chunks, of which 289 hold blocks"}};

// Chunks that hold blocks: the others cost next to nothing.
double count_chunks(const std::filesystem::path& path) {
    const minecraft::DimensionFacts facts =
        minecraft::describe(path, "overworld", false, 1).dimensions.at(0);
    if (facts.damaged != 0)
        throw util::Error("measure " + path.string() + ": " + std::to_string(facts.damaged) +
                          " damaged chunks");
    return static_cast<double>(facts.chunks - facts.empty);
}

std::size_t every_box(voxel::World& world) {
    const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, 0);
    std::size_t boxes = 0;
    for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
            for (std::int32_t by = range.min.by; by < range.max.by; ++by)
                boxes += world.box({0, bx, by, bz}) ? 1 : 0;
    return boxes;
}

// Reading and unpacking the chunks, without a look at what is in them: nothing can be faster.
double bare_s(const std::filesystem::path& path) {
    double out = 0;
    for (int pass = 0; pass < kPasses; ++pass)
        out += measure_cost([&] {
                   const minecraft::WorldFolder folder(path, kMemoryBytes);
                   const minecraft::ChunkStore store(folder, folder.dimension("overworld"), 1);
                   minecraft::ChunkStore::Reader reader;
                   for (const minecraft::ChunkRef& chunk : store.chunks())
                       if (store.read(chunk, reader).nbt.empty())
                           throw util::Error("read a chunk: nothing came out");
               }).cpu_s;
    return out / kPasses;
}

void measure(const std::filesystem::path& path, const minecraft::BlockTable& blocks, double chunks,
             Readings& readings) {
    double open_s = 0;
    double boxes_s = 0;
    double boxes = 0;
    for (int pass = 0; pass < kPasses; ++pass) {
        std::unique_ptr<voxel::World> world;
        open_s += measure_cost([&] {
                      world = minecraft::open_minecraft_world({path, "overworld", kMemoryBytes, 1},
                                                              blocks);
                  }).cpu_s /
                  kPasses;
        boxes_s +=
            measure_cost([&] { boxes = static_cast<double>(every_box(*world)); }).cpu_s / kPasses;
    }
    const double bare = bare_s(path);
    readings.add("chunks with blocks", "chunks", chunks);
    readings.add("boxes", "boxes", boxes);
    readings.add("open 1t", "ms", open_s * 1e3);
    readings.add("into boxes 1t", "chunks/s", chunks / boxes_s, at_least(1500));
    readings.add("open and into boxes 1t", "chunks/s", chunks / (open_s + boxes_s));
    readings.add("into boxes / bare", "x", boxes_s / bare);
}

Entry entry_for(const WorldSet& set) {
    Entry out;
    out.name = std::string("world/minecraft/") + set.id;
    out.measures =
        "opening a Minecraft world and making all its finest boxes: processor time of one thread";
    out.work = std::string(set.facts) + ", from cold caches, " + std::to_string(kPasses) + " times";
    out.floor = "reading and inflating the same chunks";
    out.missing = [&set](const Context& c) {
        return std::filesystem::exists(c.data / set.path) ? std::string()
                                                          : std::string(set.path) + " is not there";
    };
    out.prepare = [&set](const Context& c) -> Body {
        const auto blocks = std::make_shared<minecraft::BlockTable>(
            minecraft::BlockTable::load(util::config_dir() / "blocks"));
        const std::filesystem::path path = c.data / set.path;
        return [blocks, path, chunks = count_chunks(path)](Readings& readings) {
            measure(path, *blocks, chunks, readings);
        };
    };
    return out;
}

const Registration kRegistered([] {
    std::vector<Entry> out;
    for (const WorldSet& set : kSets)
        out.push_back(entry_for(set));
    return out;
});

}  // namespace
}  // namespace terravox::bench::world_minecraft_entry
