#include "common/voxel/archive/shard.hpp"

#include <xxhash.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"

namespace terravox::voxel::archive {
namespace {

constexpr std::uint64_t kMaxShard_bytes = 16 << 20;

/// @return 0 for what is no number of a shard
int number_in(const nlohmann::json& value) {
    const bool fits = value.is_number_unsigned() && value.get<std::uint64_t>() <= kMaxShards;
    return fits ? value.get<int>() : 0;
}

}  // namespace

std::string json_of(const Shard& shard) {
    nlohmann::ordered_json out;
    out["shard"] = shard.number;
    out["of"] = shard.of;
    out["job"] = shard.job;
    out["damage"] = shard.damage;
    return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Shard read_shard(ByteSource& source, const ArchiveIndex& index) {
    const auto damaged = [&] {
        return util::Error("open the shard " + source.name() + ": its end is damaged");
    };
    const Header& header = index.header();
    const std::uint64_t begin = header.root_offset + header.root_bytes;
    if (header.file_bytes - begin < sizeof(std::uint64_t) ||
        header.file_bytes - begin > kMaxShard_bytes)
        throw damaged();
    std::vector<std::byte> room;
    const auto bytes =
        source.read(begin, static_cast<std::size_t>(header.file_bytes - begin), room);
    const std::size_t size = bytes.size() - sizeof(std::uint64_t);
    std::uint64_t checksum = 0;
    std::memcpy(&checksum, bytes.data() + size, sizeof checksum);
    if (checksum != XXH64(bytes.data(), size, 0))
        throw damaged();
    try {
        const auto* text = reinterpret_cast<const char*>(bytes.data());
        const auto json = nlohmann::json::parse(text, text + size);
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

}  // namespace terravox::voxel::archive
