#include "raytracer/preview/command_line.hpp"

#include "common/util/shell_words.hpp"
#include "raytracer/scene/scene_io.hpp"

namespace terravox {

std::string render_command_line(const Scene& scene, const std::vector<std::string>& world,
                                const std::string& picture) {
    std::string out = "terravox render";
    const auto add = [&](const std::string& word) { out += " " + cluster::shell_word(word); };
    for (const std::string& word : world)
        add(word);
    // In one word each: numbers below zero would be taken for flags.
    for (const FieldText& field : changed_fields(scene, Scene{}))
        if (field.text)
            out += " " + flag_of(field.path) + "=" + cluster::shell_word(*field.text);
    add("-o"), add(picture);
    return out;
}

}  // namespace terravox
