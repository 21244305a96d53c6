#include "voxelserver/out/archive/stac_command.hpp"

#include <CLI/CLI.hpp>

namespace terravox::archive_tools {

void add_stac_options(CLI::App& app, StacArguments& arguments) {
    app.add_option("files", arguments.archives, "archives of places on Earth")->required();
    app.add_option("-o,--output", arguments.folder, "folder of NAME.json and collection.json")
        ->required();
    app.add_option("--datetime", arguments.datetime,
                   "when the data were taken: 2023-04-01, 2023-04-01T10:30:00Z, or two of these "
                   "with a slash")
        ->required();
    app.add_option("--href", arguments.href,
                   "address of the archives' folder; default: relative to the items");
    app.add_option("--collection", arguments.collection,
                   "id of the collection; default: none for one archive, else the folder's name");
    app.add_flag("--overwrite", arguments.overwrite, "replace the files that are there");
}

}  // namespace terravox::archive_tools
