#include "common/voxel/archive/end_json.hpp"

#include <xxhash.h>

#include <cstring>

#include "common/util/error.hpp"
#include "common/util/json_text.hpp"

namespace terravox::voxel::archive {

nlohmann::json end_json(ByteSource& source, const ArchiveIndex& index, const char* what) {
    constexpr std::uint64_t kMax_bytes = 16 << 20;
    const auto damaged = [&] {
        return util::Error(std::string("open the ") + what + " " + source.name() +
                           ": its end is damaged");
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

}  // namespace terravox::voxel::archive
