#include "raytracer/core/output/picture_info.hpp"

#include <string_view>

#include "common/util/printable.hpp"

namespace terravox::output {
namespace {

std::string clean(std::string_view text) {
    constexpr std::string_view kKept = "\n\t";
    std::string out;
    while (true) {
        const std::size_t end = text.find_first_of(kKept);
        out += util::printable(text.substr(0, end));
        if (end == std::string_view::npos)
            return out;
        out += text[end];
        text.remove_prefix(end + 1);
    }
}

}  // namespace

PictureInfo with_clean_texts(PictureInfo info) {
    for (auto& [name, value] : info.metadata)
        value = clean(value);
    return info;
}

}  // namespace terravox::output
