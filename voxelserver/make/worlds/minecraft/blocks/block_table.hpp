#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/material.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_pattern.hpp"

namespace terravox::minecraft {

/// What a block is represented by.
struct BlockAppearance {
    voxel::Material material = voxel::Material::kUnknown;
    bool has_colour = false;
    voxel::Rgb8 colour;
    /// Some entry of the table matches; else the material is kUnknown, which is visible.
    bool known = false;
    [[nodiscard]] voxel::VoxelAttr to_attr() const noexcept {
        voxel::VoxelAttr out;
        out.material = material;
        if (has_colour) {
            out.flags = voxel::VoxelAttr::kHasColour;
            out.colour = colour;
        }
        return out;
    }
    friend bool operator==(const BlockAppearance&, const BlockAppearance&) = default;
};

struct TextHash {
    using is_transparent = void;
    [[nodiscard]] std::size_t operator()(std::string_view text) const noexcept {
        return std::hash<std::string_view>{}(text);
    }
};
/// Values by text, which is looked up without a copy.
template <class Value>
using ByName = std::unordered_map<std::string, Value, TextHash, std::equal_to<>>;

/// Logs names that match no entry of a table, once each, up to kLogged. Thread-safe.
class UnknownNames {
public:
    static constexpr std::size_t kLogged = 20;
    /// @param attempt begins messages: "no table knows the block"; must outlive this
    explicit UnknownNames(const char* attempt) : m_attempt(attempt) {}
    void add(std::string_view name);
    /// How many different ones there were.
    [[nodiscard]] std::size_t count() const;

private:
    const char* const m_attempt;
    mutable std::mutex m_mutex;
    std::unordered_set<std::string> m_names;
};

/// Which material and colour each block of Minecraft has (config/blocks/blocks.toml,
/// old-blocks.toml). Safe to share between threads once it is made.
class BlockTable {
public:
    /// @param folder holds blocks.toml and old-blocks.toml
    /// @throws UsageError naming file, entry, value and allowed values
    [[nodiscard]] static BlockTable load(const std::filesystem::path& folder);
    /// The table of another game: one file in the form of blocks.toml, no older names or numbers.
    /// @throws UsageError as load()
    [[nodiscard]] static BlockTable load_names(const std::filesystem::path& file);

    /// @param name with or without its namespace ("minecraft:"); old names are known as well
    [[nodiscard]] BlockAppearance of(std::string_view name, Properties properties) const;
    /// The same for a game in which the namespace is part of a name, and which has no older names.
    [[nodiscard]] BlockAppearance of_full_name(std::string_view name) const {
        return find_appearance(name, {});
    }
    /// A block of a world before 1.13.
    /// @param data 0 to 15, other bits are ignored
    [[nodiscard]] BlockAppearance of_number(int id, int data) const;
    /// The name that the block has today, with its properties ("snow[layers=3]"); "id:data" for one
    /// that no version had.
    [[nodiscard]] std::string name_of_number(int id, int data) const;

    /// Sets the materials of these blocks, by name and whatever their properties, as listed in an
    /// exported world's side-car. Colours stay. Numbers stay as they were.
    void overlay(const std::map<std::string, voxel::Material>& blocks);

private:
    friend class BlockTableReader;
    struct Candidate {
        std::vector<Condition> conditions;
        BlockAppearance appearance;
        std::size_t own = 0;  ///< own_letters() of its pattern
        bool fixed = false;   ///< waterlogged=true has no effect
    };
    struct Wildcard {
        std::string pattern;
        Candidate candidate;
    };
    struct Renamed {
        std::string name;
        std::vector<Condition> conditions;  ///< the block's properties, one value each
    };
    static constexpr int kNumbers = 256;
    static constexpr int kData = 16;

    [[nodiscard]] BlockAppearance find_appearance(std::string_view name,
                                                  Properties properties) const;
    [[nodiscard]] BlockAppearance chosen(const Candidate& candidate, Properties properties) const;

    ByName<std::vector<Candidate>> m_names;  ///< best first
    std::vector<Wildcard> m_wildcards;       ///< best first
    ByName<Renamed> m_renamed;
    /// Materials that are water when waterlogged.
    std::array<bool, voxel::kMaterialCount> m_drowned{};
    /// By number, then data; empty: no such number.
    std::vector<std::vector<std::string>> m_number_names;
    std::vector<BlockAppearance> m_number_appearances;  ///< number * 16 + data
};

}  // namespace terravox::minecraft
