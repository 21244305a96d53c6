#include "voxelserver/out/export/formats/formats.hpp"

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "voxelserver/out/export/anvil/write_anvil.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"
#include "voxelserver/out/export/mesh/mesh.hpp"
#include "voxelserver/out/export/vdb/vdb.hpp"
#include "voxelserver/out/export/vox/vox.hpp"

namespace terravox::exports {
std::span<const Format* const> formats() noexcept {
    static constexpr const Format* kFormats[] = {
        &kArchiveFormat, &anvil::kAnvilFormat, &kVoxFormat,
#ifdef TERRAVOX_VDB
        &kVdbFormat,
#endif
        &kGlbFormat,     &kPlyFormat,
    };
    return kFormats;
}

std::string allowed_formats() {
    std::string out;
    for (const Format* const format : formats()) {
        out += out.empty() ? "" : ", ";
        out += format->name;
        out += format->extension.empty() ? " (a folder: " : " (";
        out += format->extension.empty() ? format->folder : format->extension;
        out += ")";
    }
    return out;
}

const Format& find_format_by(std::string_view name, const std::filesystem::path& out) {
    const std::string extension = util::lower_extension(out);
    for (const Format* const format : formats()) {
        if (name.empty() ? format->extension == extension : format->name == name)
            return *format;
    }
    if (name.empty()) {
        throw util::UsageError("convert to " + out.string() + ": it ends in '" + extension +
                               "'; allowed: " + allowed_formats() + ", or say which with --to");
    }
    throw util::UsageError("convert: --to " + std::string(name) +
                           "; allowed: " + allowed_formats());
}

}  // namespace terravox::exports
