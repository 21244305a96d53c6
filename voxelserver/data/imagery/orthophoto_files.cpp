#include "voxelserver/data/imagery/orthophoto_files.hpp"

#include "common/util/files.hpp"

namespace terravox::imagery {

std::vector<std::filesystem::path> orthophoto_files(
    const std::vector<std::filesystem::path>& paths) {
    return util::expand_folders(paths, {".tif", ".tiff", ".vrt", ".jp2", ".jpg", ".jpeg", ".png"},
                                "orthophotos");
}

}  // namespace terravox::imagery
