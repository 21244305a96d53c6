#include "voxelserver/make/worlds/remote/remote_kind.hpp"

#include "voxelserver/make/worlds/kind/http_address.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"
#include "voxelserver/make/worlds/remote/remote_world.hpp"

namespace terravox::worlds {
namespace {

std::unique_ptr<voxel::World> open_server(const OpenRequest& request) {
    return remote::open_remote_world(request.input(), request.times, request.options.box_timeout,
                                     request.stop, remote::access_of_environment());
}

}  // namespace

constinit const WorldKind kServerKind{
    .noun = "the address of a voxel server",
    .input = "the http:// address of a voxel server or box archive",
    .recognises = is_http_address,
    .open = open_server,
    .flags = "--processing-box-timeout-s",
    .is_path = false,
    .farm_access = FarmAccess::kByAddress,
};

}  // namespace terravox::worlds
