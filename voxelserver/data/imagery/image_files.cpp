#include "voxelserver/data/imagery/image_files.hpp"

#include <charconv>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "common/geo/raster_gate.hpp"
#include "common/util/files.hpp"
#include "common/util/text.hpp"
#include "common/util/utf8.hpp"
#include "common/voxel/fingerprint.hpp"

namespace terravox::imagery {

std::vector<std::filesystem::path> orthophoto_files(
    const std::vector<std::filesystem::path>& paths) {
    return util::expand_folders(paths, {".tif", ".tiff", ".vrt", ".jp2", ".jpg", ".jpeg", ".png"},
                                "orthophotos");
}

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kBlank = " \t\r\n";

/// @param name the text between & and ;
bool append_entity(std::string& out, std::string_view name) {
    constexpr std::pair<std::string_view, char> kNamed[] = {
        {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}};
    for (const auto& [known, character] : kNamed)
        if (name == known) {
            out.push_back(character);
            return true;
        }
    if (name.size() < 2 || name[0] != '#')
        return false;
    const bool hex = util::lower_case(name[1]) == 'x';
    const std::string_view digits = name.substr(hex ? 2 : 1);
    std::uint32_t code = 0;
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), code, hex ? 16 : 10);
    if (error != std::errc() || end != digits.data() + digits.size() || code == 0 ||
        code > 0x10ffff)
        return false;
    util::append_utf8(out, code);
    return true;
}

std::string unescaped(std::string_view text) {
    constexpr std::size_t kLongest = 10;  // length of an entity
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const std::size_t end =
            text[i] == '&' ? text.substr(i, kLongest + 2).find(';') : std::string_view::npos;
        if (end != std::string_view::npos && append_entity(out, text.substr(i + 1, end - 1)))
            i += end;
        else
            out.push_back(text[i]);
    }
    return out;
}

/// The value of relativeToVRT among the attributes of an element.
bool is_relative(std::string_view attributes) {
    for (;;) {
        const std::size_t equals = attributes.find('=');
        if (equals == std::string_view::npos)
            return false;
        const std::string_view name = util::trimmed(attributes.substr(0, equals));
        attributes = attributes.substr(equals + 1);
        const std::size_t open = attributes.find_first_not_of(kBlank);
        if (open == std::string_view::npos || (attributes[open] != '"' && attributes[open] != '\''))
            return false;
        const std::size_t close = attributes.find(attributes[open], open + 1);
        if (close == std::string_view::npos)
            return false;
        // GDAL compares names of elements and attributes case-insensitively.
        if (util::equal_but_for_case(name, "relativeToVRT"))
            return util::trimmed(attributes.substr(open + 1, close - open - 1)) == "1";
        attributes = attributes.substr(close + 1);
    }
}

}  // namespace

std::vector<fs::path> vrt_sources(std::string_view text, const fs::path& folder, std::size_t most) {
    std::vector<fs::path> out;
    std::set<fs::path> seen;  // each band of a mosaic names the same files
    // Never moves backwards: for any text, each byte is examined only a few times.
    for (std::size_t at = text.find('<'); at != std::string_view::npos && out.size() < most;
         at = text.find('<', at)) {
        const std::size_t name_end = text.find_first_of(" \t\r\n/><", ++at);
        if (name_end == std::string_view::npos)
            break;
        const std::string_view name = text.substr(at, name_end - at);
        if (!util::equal_but_for_case(name, "SourceFilename") &&
            !util::equal_but_for_case(name, "SourceDataset"))
            continue;
        const std::size_t begin = text.find('>', name_end);
        const std::size_t end = begin == std::string_view::npos ? begin : text.find('<', begin);
        if (end == std::string_view::npos)
            break;
        at = end;
        const std::string file = unescaped(util::trimmed(text.substr(begin + 1, end - begin - 1)));
        if (file.empty() || file.find('\0') != std::string::npos)
            continue;
        fs::path path =
            is_relative(text.substr(name_end, begin - name_end)) ? folder / file : fs::path(file);
        if (seen.insert(path).second)
            out.push_back(std::move(path));
    }
    return out;
}

namespace {

constexpr int kMaxDepth = 4;               // a .vrt of .vrts
constexpr std::size_t kMaxSources = 4096;  // of one .vrt
constexpr std::size_t kMaxVrtBytes = std::size_t{16} << 20;

// Reads the text, not the images: computing the identity of a world must not require access to
// them.
std::vector<fs::path> list_sources(const fs::path& vrt) {
    return vrt_sources(util::read_start(vrt, kMaxVrtBytes), vrt.parent_path(), kMaxSources);
}

void add(voxel::ByteWriter& out, const fs::path& file, int depth) {
    out.add(voxel::file_identity(file, "orthophoto"));
    std::error_code ignored;
    for (const fs::path& other : geo::side_files(file))
        if (other != file && fs::is_regular_file(other, ignored)) {
            out.add(other.extension().string());
            out.add(voxel::file_identity(other, "orthophoto"));
        }
    if (util::lower_extension(file) != ".vrt" || depth >= kMaxDepth)
        return;
    for (const fs::path& source : list_sources(file))
        if (source != file && fs::is_regular_file(source, ignored))
            add(out, source, depth + 1);
}

}  // namespace

voxel::Fingerprint image_identity(const fs::path& file) {
    voxel::ByteWriter out;
    add(out, file, 0);
    return out.fingerprint();
}

}  // namespace terravox::imagery
