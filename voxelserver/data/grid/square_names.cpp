#include "voxelserver/data/grid/square_names.hpp"

#include <algorithm>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "common/util/toml_file.hpp"

namespace terravox::grid {

namespace fs = std::filesystem;

namespace {

constexpr double kMetresPerKilometre = 1000;
// A name longer than this is no square's; it bounds the work of matching.
constexpr std::size_t kMaxName = 64;

/// The name without folder and endings, in lower case: "gkot_462_101.copc.laz" has two endings.
std::string find_stem(const fs::path& file) {
    std::string name = util::lower_case(file.filename().string());
    return name.substr(0, name.find('.'));
}

bool is_digit(char c) noexcept {
    return c >= '0' && c <= '9';
}
bool is_letter(char c) noexcept {
    return c >= 'a' && c <= 'z';
}

/// Consumes the characters of a kind at the beginning of a text.
template <class Is>
std::string_view take_while(std::string_view& text, const Is& is) {
    const auto end = std::find_if_not(text.begin(), text.end(), is);
    const std::string_view out = text.substr(0, static_cast<std::size_t>(end - text.begin()));
    text.remove_prefix(out.size());
    return out;
}

toml::table read_source(const fs::path& file) {
    return util::read_toml(file, [&](const std::string& what) {
        throw util::UsageError("read the source {}: {}", file.string(), what);
    });
}

double to_number(std::string_view digits) {
    double out = 0;
    for (const char c : digits)
        out = 10 * out + (c - '0');
    return out;
}

}  // namespace

/// Makes a rule of the last part of an address.
class RuleReader {
public:
    /// @return nullopt where the name does not state a place by itself
    static std::optional<SquareNames::Rule> read(std::string_view address) {
        RuleReader reader;
        const std::string name = util::lower_case(address.substr(address.rfind('/') + 1));
        std::string_view rest(name);
        rest = rest.substr(0, rest.find('.'));
        while (!rest.empty()) {
            if (rest.front() != '{') {
                reader.text(take_while(rest, [](char c) { return c != '{'; }));
                continue;
            }
            rest.remove_prefix(1);
            reader.placeholder(take_while(rest, [](char c) { return c != '}' && c != ':'; }));
            take_while(rest, [](char c) { return c != '}'; });
            if (rest.empty())
                return std::nullopt;
            rest.remove_prefix(1);
        }
        if (reader.m_east != 1 || reader.m_north != 1 || !reader.m_letters)
            return std::nullopt;
        return reader.m_rule;
    }

private:
    using Kind = SquareNames::Token::Kind;

    void text(std::string_view literal) {
        m_letters = m_letters || std::any_of(literal.begin(), literal.end(), is_letter);
        m_rule.tokens.push_back({Kind::kText, std::string(literal)});
    }
    void placeholder(std::string_view name) {
        const bool kilometres = name == "e" || name == "n";
        const bool east = name == "e" || name == "x";
        const bool north = name == "n" || name == "y";
        if (east || north)
            m_rule.unit_m = kilometres ? kMetresPerKilometre : 1;
        m_east += east ? 1 : 0;
        m_north += north ? 1 : 0;
        m_rule.tokens.push_back({east ? Kind::kEast : north ? Kind::kNorth : Kind::kAnyWord, {}});
    }

    SquareNames::Rule m_rule;
    bool m_letters = false;
    int m_east = 0;
    int m_north = 0;
};

SquareNames SquareNames::load(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed))
        if (entry.path().extension() == ".toml")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    SquareNames out;
    for (const fs::path& file : files) {
        const toml::table root = read_source(file);
        const auto id = root["id"].value<std::string>();
        const auto crs = root["crs"].value<std::string>();
        const auto square_m = root["square_m"].value<double>();
        const auto* urls = root["access"]["urls"].as_array();
        if (!id || !crs || !square_m || !(*square_m > 0) || urls == nullptr)
            continue;  // its squares are named by an index
        for (const auto& url : *urls) {
            auto rule = RuleReader::read(url.value_or(std::string()));
            if (!rule)
                continue;
            rule->source = *id;
            rule->crs = *crs;
            rule->class_table = root["class_table"].value_or(std::string());
            rule->square_m = *square_m;
            out.m_rules.push_back(std::move(*rule));
        }
    }
    return out;
}

std::optional<NamedSquare> SquareNames::match(const Rule& rule, const std::string& stem) {
    std::string_view rest(stem);
    std::string_view east;
    std::string_view north;
    for (const Token& token : rule.tokens) {
        switch (token.kind) {
            case Token::Kind::kText:
                if (!rest.starts_with(token.text))
                    return std::nullopt;
                rest.remove_prefix(token.text.size());
                break;
            case Token::Kind::kEast: east = take_while(rest, is_digit); break;
            case Token::Kind::kNorth: north = take_while(rest, is_digit); break;
            case Token::Kind::kAnyWord:
                take_while(rest, [](char c) { return is_digit(c) || is_letter(c); });
                break;
        }
    }
    constexpr std::size_t kMaxDigits = 7;
    if (!rest.empty() || east.empty() || north.empty() || east.size() > kMaxDigits ||
        north.size() > kMaxDigits)
        return std::nullopt;
    const char* begin = std::min(east.data(), north.data());
    const char* end = std::max(east.data() + east.size(), north.data() + north.size());
    NamedSquare square;
    square.numbers = std::string(begin, end);
    square.source = rule.source;
    square.crs = rule.crs;
    square.class_table = rule.class_table;
    square.west = rule.unit_m * to_number(east);
    square.south = rule.unit_m * to_number(north);
    square.east = square.west + rule.square_m;
    square.north = square.south + rule.square_m;
    return square;
}

std::optional<NamedSquare> SquareNames::find_square(const fs::path& file) const {
    const std::string stem = find_stem(file);
    if (stem.size() > kMaxName)
        return std::nullopt;
    std::optional<NamedSquare> found;
    for (const Rule& rule : m_rules) {
        auto square = match(rule, stem);
        if (!square)
            continue;
        if (found && found->crs != square->crs)
            return std::nullopt;
        if (!found)
            found = std::move(square);
    }
    if (found)
        found->file = file.filename().string().substr(0, stem.size());
    return found;
}

std::optional<std::string> source_title(const fs::path& folder, const std::string& id) {
    const fs::path file = folder / (id + ".toml");
    std::error_code failed;
    if (!fs::is_regular_file(file, failed))
        return std::nullopt;
    return read_source(file)["title"].value<std::string>();
}

bool is_named_like(const fs::path& image, const NamedSquare& square) {
    const std::string stem = find_stem(image);
    return stem == util::lower_case(square.file) || stem == square.numbers;
}

}  // namespace terravox::grid
