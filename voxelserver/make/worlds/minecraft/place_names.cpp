#include "voxelserver/make/worlds/minecraft/place_names.hpp"

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
std::string_view to_root(std::string_view dimension) noexcept {
    if (is_dim_folder(to_name(dimension)))
        return find_folder(dimension);
    const std::string_view pack = find_folder(dimension);
    const std::string_view all = find_folder(pack);
    if (!pack.empty() && to_name(all) == "dimensions")
        return find_folder(all);
    return dimension;
}

void place_in_world(PlacedFile& file, std::string_view dimension) noexcept {
    file.root = to_root(dimension);
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
        place_in_world(out, tree ? find_folder(outer) : folder);
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
    place_in_world(out, to_name(folder) == "region" ? find_folder(folder) : folder);
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
    if (!folder.starts_with("dimensions/"))
        return std::string(folder);
    const std::string_view pack = to_name(find_folder(folder));
    return std::string(pack) + ":" + std::string(to_name(folder));
}

}  // namespace terravox::minecraft
