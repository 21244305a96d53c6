#include "voxelserver/data/imagery/image_identity.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "common/geo/side_files.hpp"
#include "common/util/letter_case.hpp"
#include "common/voxel/bytes.hpp"
#include "common/voxel/file_identity.hpp"
#include "voxelserver/data/imagery/vrt_sources.hpp"

namespace terravox::imagery {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxDepth = 4;               // a .vrt of .vrts
constexpr std::size_t kMaxSources = 4096;  // of one .vrt
constexpr std::size_t kMaxVrtBytes = std::size_t{16} << 20;

// Reads the text, not the images: computing the identity of a world must not require access to
// them.
std::vector<fs::path> sources_of(const fs::path& vrt) {
    std::ifstream in(vrt, std::ios::binary);
    std::error_code failed;
    const std::uintmax_t size = fs::file_size(vrt, failed);
    std::string text(
        failed ? 0 : static_cast<std::size_t>(std::min<std::uintmax_t>(size, kMaxVrtBytes)), '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    return vrt_sources(text, vrt.parent_path(), kMaxSources);
}

void add(voxel::ByteWriter& out, const fs::path& file, int depth) {
    out.add(voxel::file_identity(file, "orthophoto"));
    std::error_code ignored;
    for (const fs::path& other : geo::side_files(file))
        if (other != file && fs::is_regular_file(other, ignored)) {
            out.add(other.extension().string());
            out.add(voxel::file_identity(other, "orthophoto"));
        }
    if (util::lower_extension(file) != ".vrt" || depth >= kMaxDepth)
        return;
    for (const fs::path& source : sources_of(file))
        if (source != file && fs::is_regular_file(source, ignored))
            add(out, source, depth + 1);
}

}  // namespace

voxel::Fingerprint image_identity(const fs::path& file) {
    voxel::ByteWriter out;
    add(out, file, 0);
    return out.fingerprint();
}

}  // namespace terravox::imagery
