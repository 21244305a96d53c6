#include "common/voxel/archive/archive_parts.hpp"

#include <xxhash.h>
#include <algorithm>
#include <array>
#include <cstring>

#include "common/util/error.hpp"
#include "common/util/json_text.hpp"
#include "common/voxel/archive/end_json.hpp"

namespace terravox::voxel::archive {

nlohmann::json end_json(ByteSource& source, const ArchiveIndex& index, const char* what) {
    constexpr std::uint64_t kMax_bytes = 16 << 20;
    const auto damaged = [&] {
        return util::Error("open the {} {}: its end is damaged", what, source.name());
    };
    const Header& header = index.header();
    const std::uint64_t begin = header.root_offset + header.root_bytes;
    if (header.file_bytes - begin < sizeof(std::uint64_t) || header.file_bytes - begin > kMax_bytes)
        throw damaged();
    std::vector<std::byte> room;
    const auto bytes =
        source.read(begin, static_cast<std::size_t>(header.file_bytes - begin), room);
    const std::size_t size = bytes.size() - sizeof(std::uint64_t);
    std::uint64_t checksum = 0;
    std::memcpy(&checksum, bytes.data() + size, sizeof checksum);
    if (checksum != XXH64(bytes.data(), size, 0))
        throw damaged();
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    nlohmann::json out = util::parse_json({text, size});
    if (out.is_discarded())
        throw damaged();
    return out;
}

namespace {

/// @return 0 for what is no number of a shard
int number_in(const nlohmann::json& value) {
    const bool fits = value.is_number_unsigned() && value.get<std::uint64_t>() <= kMaxShards;
    return fits ? value.get<int>() : 0;
}

}  // namespace

std::string to_json(const Shard& shard) {
    nlohmann::ordered_json out;
    out["shard"] = shard.number;
    out["of"] = shard.of;
    out["job"] = shard.job;
    out["damage"] = shard.damage;
    return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Shard read_shard(ByteSource& source, const ArchiveIndex& index) {
    const auto damaged = [&] {
        return util::Error("open the shard {}: its end is damaged", source.name());
    };
    const nlohmann::json json = end_json(source, index, "shard");
    try {
        Shard out;
        out.number = number_in(json.at("shard"));
        out.of = number_in(json.at("of"));
        json.at("job").get_to(out.job);
        json.at("damage").get_to(out.damage);
        if (out.of < 1 || out.number < 1 || out.number > out.of)
            throw damaged();
        return out;
    } catch (const nlohmann::json::exception&) {
        throw damaged();
    }
}

namespace {

nlohmann::ordered_json runs_json(const ColumnSet& columns) {
    auto out = nlohmann::ordered_json::array();
    for (const ColumnRun& run : columns.runs())
        out.push_back({run.bz, run.min_bx, run.max_bx});
    return out;
}

/// @throws nlohmann::json::exception, Error
ColumnSet runs_from(const nlohmann::json& value) {
    std::vector<ColumnRun> out;
    for (const nlohmann::json& run : value) {
        const auto numbers = run.get<std::array<std::int32_t, 3>>();
        out.push_back({numbers[0], numbers[1], numbers[2]});
        if (numbers[1] >= numbers[2] || !in_range({0, numbers[1], 0, numbers[0]}) ||
            !in_range({0, numbers[2] - 1, 0, numbers[0]}))
            throw util::Error("no columns");
    }
    return ColumnSet(std::move(out));
}

}  // namespace

ColumnSet::ColumnSet(std::vector<ColumnRun> runs) {
    std::sort(runs.begin(), runs.end());
    for (const ColumnRun& run : runs) {
        if (run.min_bx >= run.max_bx)
            continue;
        if (!m_runs.empty() && m_runs.back().bz == run.bz && run.min_bx <= m_runs.back().max_bx)
            m_runs.back().max_bx = std::max(m_runs.back().max_bx, run.max_bx);
        else
            m_runs.push_back(run);
    }
}

std::uint64_t ColumnSet::count() const noexcept {
    std::uint64_t sum = 0;
    for (const ColumnRun& run : m_runs)
        sum += static_cast<std::uint64_t>(std::int64_t{run.max_bx} - run.min_bx);
    return sum;
}

bool ColumnSet::touches(std::int32_t bz, std::int64_t min_bx, std::int64_t max_bx) const {
    // The first run of this row that does not end before the stretch begins.
    const auto run = std::partition_point(m_runs.begin(), m_runs.end(), [&](const ColumnRun& r) {
        return r.bz != bz ? r.bz < bz : r.max_bx <= min_bx;
    });
    return run != m_runs.end() && run->bz == bz && run->min_bx < max_bx;
}

bool ColumnSet::touches(const BoxKey& key) const noexcept {
    const auto first = [&](std::int64_t b) { return b * (std::int64_t{1} << key.level); };
    const auto rows_end = first(std::int64_t{key.bz} + 1);
    auto row = std::partition_point(m_runs.begin(), m_runs.end(),
                                    [&](const ColumnRun& r) { return r.bz < first(key.bz); });
    while (row != m_runs.end() && row->bz < rows_end) {
        const std::int32_t bz = row->bz;
        if (touches(bz, first(key.bx), first(std::int64_t{key.bx} + 1)))
            return true;
        row =
            std::partition_point(row, m_runs.end(), [&](const ColumnRun& r) { return r.bz <= bz; });
    }
    return false;
}

std::string to_json(const Change& change) {
    nlohmann::ordered_json out;
    out["replaced"] = runs_json(change.replaced);
    out["compared"] = runs_json(change.compared);
    out["damage"] = change.damage;
    return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Change read_change(ByteSource& source, const ArchiveIndex& index) {
    const nlohmann::json json = end_json(source, index, "change");
    try {
        Change out{runs_from(json.at("replaced")), runs_from(json.at("compared")), {}};
        json.at("damage").get_to(out.damage);
        return out;
    } catch (const std::exception&) {
        throw util::Error("open the change {}: its end is damaged", source.name());
    }
}

}  // namespace terravox::voxel::archive
