#include "voxelserver/export/core/format.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "common/util/error.hpp"

namespace terravox::exports {
namespace {

struct Known {
    Format format;
    std::string_view name, ending;
};
constexpr std::array kKnown = {
    Known{Format::kArchive, "archive", ".tvx"}, Known{Format::kAnvil, "anvil", ""},
    Known{Format::kVox, "vox", ".vox"},         Known{Format::kVdb, "vdb", ".vdb"},
    Known{Format::kGlb, "glb", ".glb"},         Known{Format::kPly, "ply", ".ply"}};

}  // namespace

std::string formats() {
    std::string out;
    for (const Known& k : kKnown)
        out += (out.empty() ? "" : ", ") + std::string(k.name) + " (" +
               (k.ending.empty() ? "a folder: a Minecraft world" : std::string(k.ending)) + ")";
    return out;
}

Format format_of(const std::string& name, const std::filesystem::path& out) {
    std::string ending = out.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const Known& k : kKnown)
        if (name.empty() ? k.ending == ending : k.name == name)
            return k.format;
    throw util::UsageError(name.empty()
                               ? "convert to " + out.string() + ": it ends in '" + ending +
                                     "'; allowed: " + formats() + ", or say which with --to"
                               : "convert: --to " + name + "; allowed: " + formats());
}

std::string_view name_of(Format format) noexcept {
    return std::find_if(kKnown.begin(), kKnown.end(),
                        [&](const Known& k) { return k.format == format; })
        ->name;
}

}  // namespace terravox::exports
