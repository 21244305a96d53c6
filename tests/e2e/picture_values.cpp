// Prints all that a picture file contains, for tests. Exit code 0: done, 2: it cannot be read.
//   picture_values FILE         size, tiles, channels with their types, and metadata, as JSON on
//                               standard output
//   picture_values FILE RAW     and all values to RAW: 32-bit floats of this machine, row by row,
//                               the channels of a pixel side by side
#include <cstdio>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/common/picture_file.hpp"

namespace {

nlohmann::json read_metadata(const terravox::test::PictureFile& picture) {
    nlohmann::json out = picture.texts;
    for (const auto& [name, values] : picture.matrices)
        out[name] = values;
    return out;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2 && argc != 3) {
        std::printf("usage: picture_values FILE [RAW]\n");
        return 2;
    }
    GDALAllRegister();
    try {
        const terravox::test::PictureFile picture = terravox::test::read_picture(argv[1]);
        nlohmann::json out = {{"width", picture.width},
                              {"height", picture.height},
                              {"tile", {picture.tile_width, picture.tile_height}},
                              {"metadata", read_metadata(picture)}};
        for (const auto& channel : picture.channels)
            out["channels"].push_back({{"name", channel.name}, {"type", channel.type}});
        std::printf("%s\n",
                    out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
        if (argc == 2)
            return 0;
        std::ofstream raw(argv[2], std::ios::binary);
        raw.write(reinterpret_cast<const char*>(picture.pixels.data()),
                  static_cast<std::streamsize>(picture.pixels.size() * sizeof(float)));
        return raw.flush() ? 0 : 2;
    } catch (const std::exception& e) {
        std::printf("cannot read %s: %s\n", argv[1], e.what());
        return 2;
    }
}
