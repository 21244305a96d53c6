#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace terravox {

/// A scene: where the camera stands, when, under which sky. All fields have defaults, with which
/// the whole world is in the picture. The fields are those of scene files and of the command
/// `terravox render`.
struct SceneText {
    std::string toml;  ///< a scene file's text; empty: none
    /// Fields over that, as on the command line: {"camera.look", "bled"}.
    std::vector<std::pair<std::string, std::string>> fields;
};

/// A picture, row by row from the top left.
struct Picture {
    std::size_t width = 0;
    std::size_t height = 0;
    std::vector<std::uint8_t> rgb;  ///< height x width x 3: sRGB, after exposure and tone curve
    /// height x width x 4: linear light (Rec. 709), and the share of the pixel that shows the
    /// world.
    std::vector<float> light;
    std::vector<float> depth_m;  ///< height x width: mean distance; infinity: nothing but sky
    struct Layer {
        std::string name;  ///< albedo, direct, indirect, normal, position, sun, water, material
        std::size_t channels = 1;
        std::vector<float> values;  ///< height x width x channels
    };
    /// With the scene's output.layers = "all".
    std::vector<Layer> layers;
    std::size_t holes = 0;  ///< boxes that rays needed and that could not be read
};

}  // namespace terravox
