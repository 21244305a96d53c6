#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "voxelserver/out/archive/stac/stac_time.hpp"

namespace terravox::stac {

/// What is written about archives for catalogues (SpatioTemporal Asset Catalog).
struct StacRequest {
    std::vector<std::filesystem::path> archives;  ///< not empty; each is one file
    std::filesystem::path folder;                 ///< of the items; made where it is missing
    StacTime time;  ///< when the data were taken: archives do not know that
    /// Address of the folder of the archives, https://example.org/data; empty: they lie in `folder`
    /// or below it, and are referred to relative to it.
    std::string href;
    /// Id of the collection; empty: none where there is one archive, else the folder's name.
    std::string collection;
    bool overwrite = false;
};

struct StacReport {
    std::vector<std::filesystem::path> files;  ///< that were written
    std::uint64_t holes = 0;                   ///< of all archives
};

/// Writes a STAC item NAME.json for each archive NAME.tvx and, for several or where it has an id, a
/// collection, collection.json (docs/formats/stac.md). All archives are read before the first file
/// is written. The bytes depend on the archives' headers, facts and indices and on the request.
/// Ref: SpatioTemporal Asset Catalog specification 1.0.0, 2021; its extensions Projection 1.1.0 and
/// File 2.1.0.
/// @throws UsageError when an archive has no place on Earth, lies elsewhere, or has the name of
/// another one, a shard or change is given, or a file is there already; Error when an archive
/// cannot be read, its place crosses the antimeridian or holds a pole, or a file cannot be written
StacReport write_stac(const StacRequest& request);

}  // namespace terravox::stac
