#include "voxelserver/make/worlds/open/open_world.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "common/util/files.hpp"
#include "common/util/text.hpp"
#include "voxelserver/make/worlds/heightmap/heightmap_world.hpp"
#include "voxelserver/make/worlds/minecraft/source.hpp"

namespace terravox::worlds {
namespace {

namespace fs = std::filesystem;

using namespace std::string_view_literals;

constexpr int kDeepestFolder = 3;
constexpr int kMostNames = 5000;
constexpr std::size_t kHead_bytes = 4096;

constexpr const char* kUnpack = "unpack it, and give the folder";

/// The beginning of a file that is no world.
struct Sign {
    std::size_t at;
    std::string_view bytes;
    const char* remedy;
};
constexpr const char* kImage =
    "it is an image; give it with --ortho, behind the LiDAR data or heights that it covers";
constexpr const char* kPage =
    "it is a web page, perhaps an error of a download; fetch the data again";
constexpr const char* kPacked = "it is a compressed file; unpack it, and give what is in it";
constexpr const char* kRaster =
    "it is a raster of a format that is not read; make a GeoTIFF of it with gdal_translate";
constexpr const char* kMarkedGrid =
    "it is an Esri ASCII grid behind a byte order mark; write it without the mark";
constexpr std::array kSigns = {
    Sign{0, "EHFA_HEADER_TAG"sv, kRaster},  // Erdas Imagine
    Sign{0, "CDF"sv, kRaster},
    Sign{0, "\x89HDF"sv, kRaster},
    Sign{0, "DSAA"sv, kRaster},  // Surfer
    Sign{0, "DSBB"sv, kRaster},
    Sign{0, "DSRB"sv, kRaster},
    Sign{0, "\xef\xbb\xbfncols"sv, kMarkedGrid},
    Sign{0, "\x89PNG"sv, kImage},
    Sign{0, "\xff\xd8\xff"sv, kImage},
    Sign{0, "\0\0\0\x0cjP  "sv, kImage},
    // Rasters of heights are recognised before.
    Sign{0, "II*\0"sv, kImage},
    Sign{0, "MM\0*"sv, kImage},
    Sign{0, "II+\0"sv, kImage},
    Sign{0, "MM\0+"sv, kImage},
    Sign{8, "WEBP"sv, kImage},
    Sign{0, "7z\xbc\xaf\x27\x1c"sv, kPacked},
    Sign{0, "Rar!"sv, kPacked},
    Sign{0, "\x1f\x8b"sv, kPacked},
    Sign{0, "BZh"sv, kPacked},
    Sign{0,
         "\xfd"
         "7zXZ"sv,
         kPacked},
    Sign{257, "ustar"sv, kPacked},
    Sign{0, "<!DOCTYPE html"sv, kPage},
    Sign{0, "<!doctype html"sv, kPage},
    Sign{0, "<html"sv, kPage},
};

bool has_sign(std::string_view head, const Sign& sign) {
    return head.size() >= sign.at && head.substr(sign.at).starts_with(sign.bytes);
}

std::string as_laz(fs::path file) {
    return file.replace_extension(".laz").string();
}

/// Whether a line is three numbers or more, separated by blanks, commas or semicolons.
bool is_row_of_numbers(std::string_view line) {
    constexpr std::string_view kNumber = "0123456789+-.eE";
    constexpr std::string_view kBetween = " \t,;\r";
    int numbers = 0;
    for (std::size_t at = line.find_first_not_of(kBetween); at != std::string_view::npos;
         at = line.find_first_not_of(kBetween, at)) {
        const std::size_t end = std::min(line.find_first_of(kBetween, at), line.size());
        const std::string_view word = line.substr(at, end - at);
        const bool is_number = word.find_first_not_of(kNumber) == std::string_view::npos &&
                               word.find_first_of("0123456789") != std::string_view::npos;
        if (!is_number)
            return false;
        ++numbers;
        at = end;
    }
    return numbers >= 3;
}

/// Of a text whose first or second line is a point: the first may name the columns.
std::string text_remedy(const fs::path& file, std::string_view head) {
    const std::size_t end = std::min(head.find('\n'), head.size());
    const std::string_view first = head.substr(0, end);
    const std::string_view rest = end < head.size() ? head.substr(end + 1) : std::string_view{};
    const bool has_names = !is_row_of_numbers(first);
    if (has_names && !is_row_of_numbers(rest.substr(0, rest.find('\n'))))
        return {};
    return "it is a text of points; translate it: pdal translate --reader readers.text " +
           std::string(has_names ? "" : "--readers.text.header=\"X Y Z\" ") + file.string() + " " +
           as_laz(file);
}

std::string image_remedy(const fs::path& file) {
    const auto fault = heightmap::fault_of_raster(file);
    return std::string(kImage) + (fault && !fault->empty() ? " (heights: " + *fault + ")" : "");
}

std::string zip_remedy(const fs::path& file) {
    constexpr std::size_t kCache_bytes = std::size_t{1} << 20;
    std::vector<std::string> endings;
    try {
        const auto archive = minecraft::open_source(file, kCache_bytes);
        for (const auto& entry : archive->entries())
            endings.push_back(util::lower_extension(entry.path));
    } catch (const std::exception&) {
        return "it is a damaged ZIP archive; fetch it again";
    }
    for (const auto& [ending, noun] :
         {std::pair{".laz", "LAZ files"}, std::pair{".las", "LAS files"},
          std::pair{".tif", "GeoTIFF files"}})
        if (std::find(endings.begin(), endings.end(), ending) != endings.end())
            return std::string("it is a ZIP archive of ") + noun + "; " + kUnpack;
    return std::string("it is a ZIP archive without a Minecraft world; ") + kUnpack;
}

std::string file_remedy(const fs::path& file) {
    const std::string ending = util::lower_extension(file);
    if (file.filename() == "fishnet.gpkg")
        return "it belongs to a store; give the store's folder";
    if (ending == ".zlas")
        return "it is a zLAS file; terravox grab convert makes LAZ of it";
    const std::string head = util::read_start(file, kHead_bytes);
    if (head.empty())
        return "it is empty, or cannot be read";
    if (head.starts_with("PK\x03\x04") || head.starts_with("PK\x05\x06"))
        return zip_remedy(file);
    if (head.starts_with("ASTM-E57"))
        return "it is an E57 file; translate it: pdal translate " + file.string() + " " +
               as_laz(file);
    for (const Sign& sign : kSigns)
        if (has_sign(head, sign))
            return std::string_view(sign.remedy) == kImage ? image_remedy(file) : sign.remedy;
    for (const char* points : {".pcd", ".pts", ".bpf"})
        if (ending == points)
            return "translate it: pdal translate " + file.string() + " " + as_laz(file);
    if (ending == ".toml")
        return "it is a file of settings; give a scene with --scene, behind the data";
    if (const std::string remedy = text_remedy(file, head); !remedy.empty())
        return remedy;
    if (const auto fault = heightmap::fault_of_raster(file); fault && !fault->empty())
        return "it is a raster, but no heights can be read of it: " + *fault +
               "; an image is given with --ortho";
    return {};
}

bool is_any_world(const fs::path& folder) {
    const auto kinds = world_kinds();
    return std::any_of(kinds.begin(), kinds.end(), [&](const WorldKind* kind) {
        return kind->is_path && kind->recognises(folder.string());
    });
}

/// What lies in a folder that is no world.
struct Inside {
    std::vector<fs::path> worlds;  ///< folders; none of a folder in one of them
    std::vector<fs::path> files;   ///< in the folder itself
};

Inside look_inside(const fs::path& folder) {
    Inside out;
    std::error_code failed;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied,
                                        failed);
    int names = 0;
    for (const fs::recursive_directory_iterator end; !failed && at != end && names < kMostNames;
         at.increment(failed), ++names) {
        std::error_code ignored;
        if (!at->is_directory(ignored)) {
            if (at.depth() == 0)
                out.files.push_back(at->path());
            continue;
        }
        const bool is_world = is_any_world(at->path());
        if (is_world)
            out.worlds.push_back(at->path());
        if (is_world || at.depth() + 1 >= kDeepestFolder)
            at.disable_recursion_pending();
    }
    std::sort(out.worlds.begin(), out.worlds.end());
    std::sort(out.files.begin(), out.files.end());
    return out;
}

std::string folder_remedy(const fs::path& folder) {
    std::error_code failed;
    if (fs::is_empty(folder, failed))
        return "it is empty";
    if (failed)
        return "it cannot be read: " + failed.message();
    const Inside inside = look_inside(folder);
    if (!inside.worlds.empty()) {
        constexpr std::size_t kMostNamed = 3;
        std::vector<std::string> named;
        for (const fs::path& world : inside.worlds)
            if (named.size() < kMostNamed)
                named.push_back(world.string());
        const std::size_t more = inside.worlds.size() - named.size();
        const std::string others = more > 0 ? " and " + std::to_string(more) + " more" : "";
        return "but folders in it do: " + util::comma_list(named) + others +
               "; give those that belong together";
    }
    for (const fs::path& file : inside.files) {
        if (is_any_world(file))
            return "but its file " + file.filename().string() + " does; give that";
        if (const std::string remedy = file_remedy(file); !remedy.empty())
            return "of its file " + file.filename().string() + ": " + remedy;
    }
    return {};
}

std::string missing_remedy(const fs::path& path) {
    if (path.string().find('*') != std::string::npos)
        return "no name fits the pattern";
    if (path.string().find("://") != std::string::npos)
        return "addresses begin with http:// or https://; download other data first";
    std::vector<std::string> siblings;
    std::error_code failed;
    const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
    for (fs::directory_iterator at(parent, failed), end;
         !failed && at != end && siblings.size() < kMostNames; at.increment(failed))
        siblings.push_back(at->path().filename().string());
    std::sort(siblings.begin(), siblings.end());
    const std::vector<std::string> near = util::near_words(path.filename().string(), siblings);
    return near.empty() ? "" : "did you mean " + (path.parent_path() / near.front()).string() + "?";
}

}  // namespace

std::string find_remedy(const std::string& input) {
    std::error_code failed;
    const fs::file_status status = fs::status(input, failed);
    if (!fs::exists(status))
        return missing_remedy(input);
    return fs::is_directory(status) ? folder_remedy(input) : file_remedy(input);
}

std::string find_address_remedy(const std::string& address) {
    const std::string path = util::lower_case(address.substr(0, address.find_first_of("?#")));
    for (const char* ending : {".las", ".laz", ".ply", ".e57", ".xyz", ".zip", ".tif", ".tiff"})
        if (path.ends_with(ending))
            return "it is the address of a file, which is read from this machine only; download it "
                   "first (curl -O, or terravox grab)";
    return {};
}

}  // namespace terravox::worlds
