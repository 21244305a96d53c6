#include "voxelserver/data/ply/ply_source.hpp"

namespace terravox::ply {

pointcloud::Recognition PlyFormat::recognise(std::string_view head) noexcept {
    if (!head.starts_with("ply\n") && !head.starts_with("ply\r\n"))
        return pointcloud::Recognition::kUnknown;
    constexpr std::string_view kFaces = "\nelement face ";
    const std::string_view header = head.substr(0, head.find("\nend_header"));
    const auto faces = header.find(kFaces);
    if (faces == std::string_view::npos)
        return pointcloud::Recognition::kPoints;
    // Some programs write point clouds with an empty element of faces.
    const std::string_view count = header.substr(faces + kFaces.size());
    const bool none = count == "0" || count.starts_with("0\n") || count.starts_with("0\r");
    return none ? pointcloud::Recognition::kPoints : pointcloud::Recognition::kOther;
}

}  // namespace terravox::ply
