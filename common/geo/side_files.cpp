#include "common/geo/side_files.hpp"

#include <algorithm>
#include <cctype>
#include <string>

#include "common/util/letter_case.hpp"

namespace terravox::geo {
namespace {

std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

}  // namespace

std::vector<std::filesystem::path> side_files(const std::filesystem::path& raster) {
    std::vector<std::string> endings{".wld", ".prj", ".tab", ".hdr"};
    // The extension of a world file is the raster's first and last letter, or all of it, followed
    // by a w.
    if (const std::string own = util::lower_extension(raster); own.size() > 2) {
        endings.push_back(own + "w");
        endings.push_back({'.', own[1], own.back(), 'w'});
    }
    std::vector<std::filesystem::path> out;
    for (const std::string& ending : endings)
        for (const std::string& any_case : {ending, upper(ending)})
            out.push_back(std::filesystem::path(raster).replace_extension(any_case));
    for (const char* ending : {".aux.xml", ".hdr", ".HDR", ".ovr", ".OVR", ".msk", ".MSK"})
        out.push_back(std::filesystem::path(raster) += ending);
    return out;
}

}  // namespace terravox::geo
