#include "common/voxel/fingerprint.hpp"

#include <xxhash.h>
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>

#include "common/util/error.hpp"

namespace terravox::voxel {

namespace fs = std::filesystem;

voxel::Fingerprint to_fingerprint(std::string_view bytes) noexcept {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    return {hash.high64, hash.low64};
}

voxel::Fingerprint file_identity(const fs::path& file, const char* what) {
    constexpr std::uintmax_t kEnds = 65536;
    const auto fail = [&] {
        return util::Error("read the {} {}: cannot be read", what, file.string());
    };
    std::error_code failed;
    const std::uintmax_t size = fs::file_size(file, failed);
    if (failed)
        throw fail();
    const fs::file_time_type time = fs::last_write_time(file, failed);
    if (failed)
        throw fail();
    ByteWriter out;
    out.add(static_cast<std::uint64_t>(size));
    out.add(static_cast<std::int64_t>(time.time_since_epoch().count()));
    std::ifstream in(file, std::ios::binary);
    std::string part(static_cast<std::size_t>(std::min(kEnds, size)), '\0');
    const auto read = [&] {
        in.read(part.data(), static_cast<std::streamsize>(part.size()));
        out.add(part);
    };
    read();
    in.seekg(-static_cast<std::streamoff>(part.size()), std::ios::end);
    read();
    if (!in)
        throw fail();
    return out.fingerprint();
}

std::string to_hex(const voxel::Fingerprint& print) {
    std::array<char, 33> text{};
    std::snprintf(text.data(), text.size(), "%016llx%016llx",
                  static_cast<unsigned long long>(print[0]),
                  static_cast<unsigned long long>(print[1]));
    return text.data();
}

}  // namespace terravox::voxel
