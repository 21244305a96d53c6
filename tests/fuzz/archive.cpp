// Box archives: header, text of the world, index and boxes, with checksums made right.
#include <xxhash.h>

#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/world.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {
namespace {

using namespace voxel::archive;

/// The bytes of an archive in memory.
class MemorySource final : public ByteSource {
public:
    explicit MemorySource(const Editable& bytes) : m_bytes(bytes) {}
    [[nodiscard]] const std::string& name() const noexcept override { return m_name; }
    [[nodiscard]] std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes,
                                                  std::vector<std::byte>&) override {
        if (!m_bytes.holds(offset, bytes))
            throw util::Error("read the input: it ends before that");
        return m_bytes.part(offset, bytes);
    }

private:
    const Editable& m_bytes;
    const std::string m_name = "the input";
};

void put_checksums(Editable& file) {
    if (!file.holds(0, sizeof(Header)))
        return;
    const auto header = file.get<Header>(0);
    if (file.holds(header.root_offset, header.root_bytes) &&
        header.root_bytes >= sizeof(std::uint64_t)) {
        const std::uint64_t payload = header.root_bytes - sizeof(std::uint64_t);
        for (std::uint64_t at = 0; payload - at >= sizeof(Leaf); at += sizeof(Leaf)) {
            const auto leaf = file.get<Leaf>(header.root_offset + at);
            if (!file.holds(leaf.offset, leaf.bytes))
                continue;
            const auto frame = file.part(leaf.offset, leaf.bytes);
            file.put(header.root_offset + at + offsetof(Leaf, checksum),
                     XXH64(frame.data(), frame.size(), 0));
        }
        const auto root = file.part(header.root_offset, payload);
        file.put(header.root_offset + payload, XXH64(root.data(), root.size(), 0));
    }
    file.put(offsetof(Header, checksum), XXH64(file.bytes().data(), offsetof(Header, checksum), 0));
}

}  // namespace

void run(Input input) {
    Editable file(input);
    put_checksums(file);
    const auto world = voxel::open_archive(std::make_unique<MemorySource>(file));
    const voxel::WorldInfo& info = world->info();
    (void)world->damage();
    for (int level = 0; level < info.levels; ++level) {
        if (info.bounds.empty())
            break;
        const auto range = voxel::boxes_over(info.bounds, level);
        // Corners of the range: it may hold a billion boxes.
        const voxel::BoxKey last{level, range.max.bx - 1, range.max.by - 1, range.max.bz - 1};
        for (const voxel::BoxKey& key : {range.min, last, voxel::BoxKey{level, 0, 0, 0}}) {
            (void)world->column(level, key.bx, key.bz);
            allow_errors([&] { (void)world->box({level, key.bx, key.by, key.bz}); });
        }
    }
}

}  // namespace terravox::fuzz
