#pragma once

#include <string>

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// place.json of the viewer at /view (docs/formats/site.md): this server as the source of boxes,
/// and first views of its world.
/// @throws as World::column()
[[nodiscard]] std::string view_place(Service& service);

/// The coarsest level that the viewer should request. Where coarse boxes are made from fine ones,
/// the coarsest box of an unprepared world takes as long as all of it: levels are left out then,
/// down to one of which a column is soon made from what is kept, unless there would be too many
/// columns.
/// @return a level of the world
/// @throws as World::column()
[[nodiscard]] int coarsest_for_viewer(Service& service);

}  // namespace terravox::http
