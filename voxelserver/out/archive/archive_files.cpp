#include "voxelserver/out/archive/archive_files.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/text.hpp"
#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/archive/archive_parts.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/out/archive/split.hpp"
#include "voxelserver/out/archive/verify.hpp"

namespace terravox::archive_tools {
namespace {

namespace fs = std::filesystem;
using voxel::archive::ByteSource;

/// The bytes of some files, one after the other. Thousands of them have fewer descriptors: few are
/// open at a time.
class PartsSource final : public ByteSource {
public:
    explicit PartsSource(const std::vector<fs::path>& files)
        : m_name(files.front().string() + " and the parts after it"), m_open(kMaxOpen) {
        for (const fs::path& file : files) {
            m_parts.push_back({file, voxel::archive::file_state(file), m_bytes});
            m_bytes += m_parts.back().state.bytes;
        }
    }
    [[nodiscard]] const std::string& name() const noexcept override { return m_name; }

    [[nodiscard]] std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes,
                                                  std::vector<std::byte>& room) override {
        if (offset > m_bytes || bytes > m_bytes - offset)
            throw util::Error("read the box archive " + m_name + ": bytes " +
                              std::to_string(offset) + " to " + std::to_string(offset + bytes) +
                              "; the parts have " + std::to_string(m_bytes) + ", some is missing");
        room.clear();
        std::vector<std::byte> own;
        for (std::size_t i = part_at(offset); room.size() < bytes; ++i) {
            const Part& part = m_parts[i];
            const std::uint64_t at = offset + room.size() - part.begin;
            const auto some = static_cast<std::size_t>(
                std::min<std::uint64_t>(bytes - room.size(), part.state.bytes - at));
            const auto read = opened(i)->source->read(at, some, own);
            room.insert(room.end(), read.begin(), read.end());
        }
        return room;
    }

private:
    static constexpr std::size_t kMaxOpen = 16;

    struct Part {
        fs::path file;
        voxel::archive::FileState state;
        std::uint64_t begin = 0;  ///< in the archive
    };
    struct OpenPart {
        std::unique_ptr<ByteSource> source;
    };

    [[nodiscard]] std::size_t part_at(std::uint64_t offset) const {
        const auto after =
            std::upper_bound(m_parts.begin(), m_parts.end(), offset,
                             [](std::uint64_t at, const Part& part) { return at < part.begin; });
        return static_cast<std::size_t>(after - m_parts.begin()) - 1;
    }
    [[nodiscard]] std::shared_ptr<const OpenPart> opened(std::size_t part) {
        return m_open.get(
            part,
            [&] {
                return std::make_shared<const OpenPart>(
                    voxel::archive::file_source(m_parts[part].file, m_parts[part].state));
            },
            [](const auto&) { return std::size_t{1}; });
    }

    std::string m_name;
    std::vector<Part> m_parts;
    std::uint64_t m_bytes = 0;
    util::Cache<std::size_t, OpenPart> m_open;  ///< limited by number
};

}  // namespace

std::unique_ptr<ByteSource> ArchiveFiles::open() const {
    if (m_files.size() == 1)
        return voxel::archive::file_source(m_files.front());
    return std::make_unique<PartsSource>(m_files);
}

std::uint64_t ArchiveFiles::bytes() const {
    std::uint64_t sum = 0;
    for (const fs::path& file : m_files)
        sum += voxel::archive::file_state(file).bytes;
    return sum;
}

bool is_first_part(const fs::path& file) {
    voxel::archive::Header header{};
    const std::string bytes = util::read_start(file, sizeof header);
    if (bytes.size() < sizeof header)
        return false;
    std::memcpy(&header, bytes.data(), sizeof header);
    return std::memcmp(header.magic, voxel::archive::kMagic, sizeof header.magic) == 0 &&
           header.file_bytes > voxel::archive::file_state(file).bytes;
}

Verification join_parts(const std::vector<fs::path>& parts, const fs::path& out, int threads) {
    for (const fs::path& part : parts) {
        std::error_code ignored;
        if (fs::equivalent(part, out, ignored))
            throw util::UsageError("merge to " + out.string() +
                                   ": it is one of the parts; allowed: another name");
    }
    const ArchiveFiles files(parts);
    // One source for both: what is copied is what was verified.
    const auto source = files.open();
    const std::uint64_t bytes = files.bytes();
    const Verification found = verify_open(*source, bytes, threads);
    if (found.problems > 0)
        throw util::Error("merge the parts of " + parts.front().string() + ": " +
                          found.first_problems.front());
    util::AtomicFile joined(out);
    append_stretch(*source, 0, bytes, joined);
    joined.commit();
    return found;
}

using voxel::archive::ArchiveIndex;
using voxel::archive::Entry;
using voxel::archive::Kind;

std::uint64_t Summary::holes() const noexcept {
    std::uint64_t count = 0;
    for (const LevelSummary& level : levels)
        count += level.holes;
    return count;
}

Summary make_summary(const ArchiveFiles& archive) {
    const auto source = archive.open();
    const ArchiveIndex index(*source, ArchiveIndex::Of::kAnyFile);
    Summary out;
    out.file_bytes = index.header().file_bytes;
    out.damage = index.header().damage;
    if (index.kind() == voxel::archive::FileKind::kShard) {
        const voxel::archive::Shard shard = voxel::archive::read_shard(*source, index);
        out.damage = static_cast<std::uint32_t>(shard.damage.size());
        out.shard = {shard.number, shard.of};
    }
    if (index.kind() == voxel::archive::FileKind::kChange) {
        const voxel::archive::Change change = voxel::archive::read_change(*source, index);
        out.damage = static_cast<std::uint32_t>(change.damage.size());
        out.replaced_columns = change.replaced.count();
    }
    out.facts = voxel::world_to_json(index.info());
    out.levels.resize(static_cast<std::size_t>(index.info().levels));
    index.each_entry([&](const Entry& entry) {
        LevelSummary& level = out.levels[static_cast<std::size_t>(entry.key.level)];
        if (entry.kind == Kind::kHole) {
            ++level.holes;
            return;
        }
        ++level.boxes;
        level.bytes += entry.bytes;
    });
    return out;
}

std::string to_text(const Summary& summary) {
    const voxel::WorldInfo world = voxel::world_from_json(summary.facts, "the archive");
    const auto row = [](std::string_view name, const std::string& text) {
        return fmt::format("{:<12} {}\n", name, util::printable(text));
    };
    const auto metres = [&](std::size_t axis) {
        return (world.bounds.max[axis] - world.bounds.min[axis]) * world.voxel_m;
    };
    std::string out;
    if (!world.title.empty())
        out += row("title", world.title);
    out += row("format", fmt::format("box archive, version {}, {:.1f} MB", voxel::archive::kVersion,
                                     static_cast<double>(summary.file_bytes) / 1e6));
    if (summary.shard.of > 0)
        out += row("shard", fmt::format("{} of {}", summary.shard.number, summary.shard.of));
    if (summary.replaced_columns)
        out +=
            row("change", fmt::format("replaces {} columns of boxes", *summary.replaced_columns));
    out += row("CRS", world.crs.empty() ? "none" : world.crs);
    out += row("extent", fmt::format("{:.1f} x {:.1f} m, {:.1f} m high; voxels of {} m", metres(0),
                                     metres(2), metres(1), world.voxel_m));
    if (!world.licence.empty())
        out += row("licence", world.licence);
    if (!world.attribution.empty())
        out += row("attribution", world.attribution);
    out += row("damage", fmt::format("{} in the data that it was made from", summary.damage));
    for (std::size_t i = 0; i < summary.levels.size(); ++i) {
        const LevelSummary& level = summary.levels[i];
        out += row(fmt::format("level {}", i),
                   fmt::format("{} boxes, {:.1f} MB; {} holes", level.boxes,
                               static_cast<double>(level.bytes) / 1e6, level.holes));
    }
    return out;
}

std::string to_json(const Summary& summary) {
    nlohmann::ordered_json out;
    out["bytes"] = summary.file_bytes;
    out["damage"] = summary.damage;
    if (summary.shard.of > 0) {
        out["shard"] = summary.shard.number;
        out["shards"] = summary.shard.of;
    }
    if (summary.replaced_columns)
        out["replaced_columns"] = *summary.replaced_columns;
    out["levels"] = nlohmann::ordered_json::array();
    for (const LevelSummary& level : summary.levels)
        out["levels"].push_back(
            {{"boxes", level.boxes}, {"holes", level.holes}, {"bytes", level.bytes}});
    out["world"] = nlohmann::ordered_json::parse(summary.facts);
    return out.dump(2, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace terravox::archive_tools
