#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"
#include "voxelserver/data/imagery/colour_map.hpp"

namespace terravox::imagery {

/// One parsed file of config/palettes, with the checks shared by all its readers. Every failure is
/// an Error that names the file, the field, the value and the allowed range.
class PaletteFile {
public:
    explicit PaletteFile(std::filesystem::path path);
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] const toml::table& root() const noexcept { return m_root; }

    [[noreturn]] void fail(const std::string& what) const;
    /// A number in [min, max]; `otherwise` where the field is not set.
    [[nodiscard]] double number(const toml::table& table, const std::string& where,
                                const char* field, double min, double max, double otherwise) const;
    [[nodiscard]] voxel::Material material(const std::string& where, const std::string& name) const;
    /// The materials of a list; 0 where the field is not set.
    [[nodiscard]] MaterialSet materials(const toml::table& table, const std::string& where,
                                        const char* field) const;
    /// The tables of [[name]]; empty where there are none.
    [[nodiscard]] std::vector<const toml::table*> rows(const char* name) const;
    /// Rejects fields that no reader uses: a misspelt one would otherwise be ignored silently.
    void allow_only(const toml::table& table, const std::string& where,
                    std::initializer_list<std::string_view> fields) const;

private:
    std::filesystem::path m_path;
    toml::table m_root;
};

/// Reads config/palettes/<id>.toml, or a path that ends in .toml, and the files that it extends:
/// the base first.
/// @throws UsageError for an unknown id (listing the available ones); Error for a bad file
[[nodiscard]] std::vector<PaletteFile> read_palette(const std::string& id_or_path);

}  // namespace terravox::imagery
