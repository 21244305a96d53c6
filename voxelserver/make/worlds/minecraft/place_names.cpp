#include "voxelserver/make/worlds/minecraft/place_names.hpp"

#include <algorithm>
#include <charconv>

namespace terravox::minecraft {
namespace {

// Parses the whole of `text` as the game writes a number: no "+", no leading zeros, no "-0".
std::optional<std::int32_t> canonical(std::string_view text, int base) noexcept {
    std::int32_t value = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (failed != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    const std::string_view digits = text.substr(text.front() == '-' ? 1 : 0);
    if (digits.front() == '0' && text.size() > 1)
        return std::nullopt;
    return value;
}

struct Place {
    std::int32_t x;
    std::int32_t z;
};

// "<letter>.X.Z.<ending>"
std::optional<Place> find_place(std::string_view name, char letter, std::string_view ending,
                                int base) noexcept {
    if (name.size() < ending.size() + 6 || name[0] != letter || name[1] != '.' ||
        !name.ends_with(ending))
        return std::nullopt;
    const std::string_view numbers = name.substr(2, name.size() - 2 - ending.size() - 1);
    if (name[name.size() - ending.size() - 1] != '.')
        return std::nullopt;
    const std::size_t dot = numbers.find('.');
    if (dot == std::string_view::npos || dot == 0 || dot + 1 == numbers.size())
        return std::nullopt;
    const auto x = canonical(numbers.substr(0, dot), base);
    const auto z = canonical(numbers.substr(dot + 1), base);
    if (!x || !z)
        return std::nullopt;
    return Place{*x, *z};
}

bool farther(const Place& place, std::int32_t limit) noexcept {
    return place.x < -limit || place.x >= limit || place.z < -limit || place.z >= limit;
}

bool is_dim_folder(std::string_view name) noexcept {
    return name.starts_with("DIM") && name.size() > 3 && canonical(name.substr(3), 10).has_value();
}

// The folder of the world, given that of a dimension. It is a prefix of the path that `dimension`
// points into.
// @param in_region  the dimension's files lie in a folder `region`; else a folder in `dimensions`
// may be one of its others, `entities` or `poi`
std::string_view to_root(std::string_view dimension, bool in_region) noexcept {
    constexpr std::string_view kAll = "dimensions/";
    for (std::size_t at = 0; in_region && at < dimension.size();) {
        const std::string_view rest = dimension.substr(at);
        // A namespace and a name, which may have slashes.
        if (rest.starts_with(kAll) && rest.find('/', kAll.size()) != std::string_view::npos)
            return dimension.substr(0, at == 0 ? 0 : at - 1);
        at += std::min(rest.find('/'), rest.size()) + 1;
    }
    return is_dim_folder(to_name(dimension)) ? find_folder(dimension) : dimension;
}

void place_in_world(PlacedFile& file, std::string_view dimension, bool in_region) noexcept {
    file.root = to_root(dimension, in_region);
    file.dimension = dimension.substr(file.root.size());
    if (file.dimension.starts_with('/'))
        file.dimension.remove_prefix(1);
}

bool is_alpha_folder(std::string_view name, std::int32_t at) noexcept {
    return canonical(name, 36) == (at & 63);
}

}  // namespace

std::string_view find_folder(std::string_view path) noexcept {
    const std::size_t slash = path.rfind('/');
    return slash == std::string_view::npos ? path.substr(0, 0) : path.substr(0, slash);
}

std::string_view to_name(std::string_view path) noexcept {
    const std::size_t slash = path.rfind('/');
    return slash == std::string_view::npos ? path : path.substr(slash + 1);
}

std::string joined(std::string_view folder, std::string_view name) {
    return folder.empty() ? std::string(name) : std::string(folder) + "/" + std::string(name);
}

std::optional<PlacedFile> placed_file(std::string_view path) noexcept {
    const std::string_view name = to_name(path);
    const std::string_view folder = find_folder(path);
    PlacedFile out;
    if (const auto chunk = find_place(name, 'c', "dat", 36)) {
        out.kind = FileKind::kAlpha;
        out.x = chunk->x;
        out.z = chunk->z;
        const std::string_view outer = find_folder(folder);
        const bool tree =
            is_alpha_folder(to_name(folder), chunk->z) && is_alpha_folder(to_name(outer), chunk->x);
        place_in_world(out, tree ? find_folder(outer) : folder, false);
        if (farther(*chunk, kFarthestChunk))
            out.refused = "its chunk lies farther out than 2097152 chunks";
        return out;
    }
    const auto anvil = find_place(name, 'r', "mca", 10);
    const auto region = anvil ? anvil : find_place(name, 'r', "mcr", 10);
    if (!region)
        return std::nullopt;
    out.kind = anvil ? FileKind::kAnvil : FileKind::kMcRegion;
    out.x = region->x;
    out.z = region->z;
    const bool in_region = to_name(folder) == "region";
    place_in_world(out, in_region ? find_folder(folder) : folder, in_region);
    if (farther(*region, kFarthestRegion))
        out.refused = "its region lies farther out than 65536 regions";
    return out;
}

std::string dimension_name(std::string_view folder) {
    if (folder.empty() || folder == "dimensions/minecraft/overworld")
        return "overworld";
    if (folder == "DIM-1" || folder == "dimensions/minecraft/the_nether")
        return "nether";
    if (folder == "DIM1" || folder == "dimensions/minecraft/the_end")
        return "end";
    constexpr std::string_view kAll = "dimensions/";
    if (!folder.starts_with(kAll))
        return std::string(folder);
    const std::string_view name = folder.substr(kAll.size());
    const std::size_t slash = std::min(name.find('/'), name.size());
    return std::string(name.substr(0, slash)) + ":" +
           std::string(name.substr(std::min(slash + 1, name.size())));
}

bool is_bedrock_file(std::string_view path) noexcept {
    return to_name(path) == "CURRENT" && to_name(find_folder(path)) == "db";
}

}  // namespace terravox::minecraft
