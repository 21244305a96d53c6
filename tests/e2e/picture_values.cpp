// Prints all that a picture file contains, for tests. Exit code 0: done, 2: it cannot be read.
//   picture_values FILE         size, tiles, channels with their types, and metadata, as JSON on
//                               standard output
//   picture_values FILE RAW     and all values to RAW: 32-bit floats of this machine, row by row,
//                               the channels of a pixel side by side
#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

namespace {

nlohmann::json metadata_of(const OIIO::ImageSpec& spec) {
    nlohmann::json out = nlohmann::json::object();
    for (const auto& entry : spec.extra_attribs) {
        nlohmann::json& value = out[entry.name().string()];
        if (entry.type().basetype == OIIO::TypeDesc::FLOAT) {
            const auto* first = static_cast<const float*>(entry.data());
            value = std::vector<float>(first, first + entry.type().basevalues());
        } else {
            value = entry.get_string();
        }
    }
    return out;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2 && argc != 3) {
        std::printf("usage: picture_values FILE [RAW]\n");
        return 2;
    }
    const auto in = OIIO::ImageInput::open(argv[1]);
    if (!in) {
        std::printf("cannot read %s: %s\n", argv[1], OIIO::geterror().c_str());
        return 2;
    }
    const OIIO::ImageSpec spec = in->spec();
    nlohmann::json out = {{"width", spec.width},
                          {"height", spec.height},
                          {"tile", {spec.tile_width, spec.tile_height}},
                          {"metadata", metadata_of(spec)}};
    for (int c = 0; c < spec.nchannels; ++c)
        out["channels"].push_back(
            {{"name", spec.channel_name(c)}, {"type", spec.channelformat(c).c_str()}});
    std::printf("%s\n", out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    if (argc == 2)
        return 0;
    std::vector<float> values(static_cast<std::size_t>(spec.image_pixels()) *
                              static_cast<std::size_t>(spec.nchannels));
    if (!in->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, values.data())) {
        std::printf("cannot read the pixels of %s: %s\n", argv[1], in->geterror().c_str());
        return 2;
    }
    std::ofstream raw(argv[2], std::ios::binary);
    raw.write(reinterpret_cast<const char*>(values.data()),
              static_cast<std::streamsize>(values.size() * sizeof(float)));
    return raw.flush() ? 0 : 2;
}
