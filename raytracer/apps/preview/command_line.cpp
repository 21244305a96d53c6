#include "raytracer/apps/preview/command_line.hpp"

#include "common/util/shell_words.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::preview {

std::string render_command_line(const scene::Scene& scene, const std::vector<std::string>& world,
                                const std::string& picture) {
    std::string out = "terravox render";
    const auto add = [&](const std::string& word) { out += " " + util::shell_word(word); };
    for (const std::string& word : world)
        add(word);
    // Option and value form one word, as negative numbers would be parsed as flags.
    for (const scene::FieldText& field : scene::changed_fields(scene, scene::Scene{}))
        if (field.text)
            out += " " + scene::flag_of(field.path) + "=" + util::shell_word(*field.text);
    add("-o");
    add(picture);
    return out;
}

}  // namespace terravox::preview
