#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::grid {

/// A square of a source's fishnet that the name of a file states.
struct NamedSquare {
    std::string file;           ///< the name without folder and endings, such as TM_462_101
    std::string numbers;        ///< the part of it that states the place, such as 462_101
    std::string source;         ///< id of the source (config/sources) whose names look like this
    std::string crs;            ///< of the source, such as EPSG:3794
    std::string class_table{};  ///< of the source, an id of config/classes; empty: it names none
    /// Closed, in metres of `crs`.
    double west = 0;
    double south = 0;
    double east = 0;
    double north = 0;
};

/// What the names of files state, by the naming rules of the sources in config/sources: the last
/// part of each address there, such as TM_{E}_{N}.laz. E and N are kilometres, x and y metres of
/// the south-west corner. Rules without a letter of their own ({E}_{N}) fit names of any country
/// and are left out. Immutable, thread-safe.
class SquareNames {
public:
    /// Reads all sources of a folder.
    /// @throws UsageError for a source file that cannot be read
    [[nodiscard]] static SquareNames load(const std::filesystem::path& folder);

    /// @param file with or without a folder; letters in any case
    /// @return nullopt where no rule fits, or where rules of sources in different CRSs fit
    [[nodiscard]] std::optional<NamedSquare> find_square(const std::filesystem::path& file) const;

private:
    /// A part of a name: a text, or what stands for a placeholder.
    struct Token {
        enum class Kind : std::uint8_t { kText, kEast, kNorth, kAnyWord } kind = Kind::kText;
        std::string text;  ///< in lower case; kText only
    };
    struct Rule {
        std::string source;
        std::string crs;
        std::string class_table;
        double square_m = 0;
        double unit_m = 1;  ///< of the numbers
        std::vector<Token> tokens;
    };
    friend class RuleReader;
    [[nodiscard]] static std::optional<NamedSquare> match(const Rule& rule,
                                                          const std::string& stem);

    std::vector<Rule> m_rules;
};

/// The title of a source.
/// @param folder as for SquareNames::load()
/// @param id from any source, without slashes
/// @return nullopt for a source that is not there
/// @throws UsageError for a source file that cannot be read
[[nodiscard]] std::optional<std::string> source_title(const std::filesystem::path& folder,
                                                      const std::string& id);

/// Whether an image is named like a square: as its file of points (TM_462_101), or by its numbers
/// alone (462_101).
[[nodiscard]] bool is_named_like(const std::filesystem::path& image, const NamedSquare& square);

}  // namespace terravox::grid
