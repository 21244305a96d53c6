#include "common/voxel/archive/shard.hpp"

#include "common/util/error.hpp"
#include "common/voxel/archive/end_json.hpp"

namespace terravox::voxel::archive {
namespace {

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

}  // namespace terravox::voxel::archive
