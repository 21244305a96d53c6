#include "voxelserver/make/worlds/archive/archive_kind.hpp"

#include "common/voxel/archive/archive_world.hpp"
#include "common/voxel/archive/byte_source.hpp"
#include "common/voxel/file_identity.hpp"
#include "voxelserver/make/worlds/archive/remote_archive.hpp"
#include "voxelserver/make/worlds/kind/http_address.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"

namespace terravox::worlds {
namespace {

bool is_file_of_boxes(const std::string& input) {
    return voxel::is_archive(input);
}

bool is_address_of_archive(const std::string& input) {
    return is_http_address(input) && names_archive(input);
}

voxel::Fingerprint state_of_file(const WorldOptions& options) {
    return voxel::file_identity(options.inputs.front(), "box archive");
}

std::unique_ptr<voxel::World> open_file(const OpenRequest& request) {
    return voxel::open_archive(voxel::archive::file_source(request.input()));
}

std::unique_ptr<voxel::World> open_remote(const OpenRequest& request) {
    return voxel::open_archive(remote_archive(request.input(), request.options.box_timeout,
                                              request.stop, remote::access_of_environment()));
}

}  // namespace

constinit const WorldKind kArchiveKind{
    .noun = "a box archive",
    .input = "a box archive (.tvx)",
    .recognises = is_file_of_boxes,
    .open = open_file,
    .state = state_of_file,
    .is_archive = true,
    .keeps_its_files = true,
};

constinit const WorldKind kRemoteArchiveKind{
    .noun = "the address of a box archive",
    .input = {},
    .recognises = is_address_of_archive,
    .open = open_remote,
    .flags = "--processing-box-timeout-s",
    .is_path = false,
    .is_archive = true,
    .farm_access = FarmAccess::kByAddress,
};

}  // namespace terravox::worlds
