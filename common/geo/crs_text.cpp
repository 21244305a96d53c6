#include "common/geo/crs.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace terravox::geo {
namespace {

constexpr std::size_t kLongestName = 80;  // limit of a quotation in a message

bool is_blank(char c) noexcept {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}
bool is_letter(char c) noexcept {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_digit(char c) noexcept {
    return c >= '0' && c <= '9';
}
char upper(char c) noexcept {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}

std::string upper(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](char c) { return upper(c); });
    return out;
}

std::string_view without_blanks(std::string_view text) noexcept {
    while (!text.empty() && is_blank(text.front()))
        text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back()))
        text.remove_suffix(1);
    return text;
}

std::string in_quotes(std::string_view text) {
    return "'" + std::string(text.substr(0, kLongestName)) + "'";
}

template <std::size_t N>
bool is_among(const std::array<std::string_view, N>& known, std::string_view text) noexcept {
    return std::find(known.begin(), known.end(), text) != known.end();
}

/// Letters, digits and the characters of numbers and of file names without a folder: no slash, no
/// colon, no blank.
bool is_plain(std::string_view text) noexcept {
    return std::all_of(text.begin(), text.end(), [](char c) {
        return is_letter(c) || is_digit(c) || c == '_' || c == '.' || c == ',' || c == '+' ||
               c == '-';
    });
}

// ---- AUTHORITY:CODE ----

bool is_authority(std::string_view text) {
    constexpr auto kAuthorities = std::to_array<std::string_view>({"EPSG", "ESRI", "IGNF", "OGC"});
    return is_among(kAuthorities, upper(text));
}

bool is_code(std::string_view text) noexcept {
    constexpr std::size_t kLongest = 32;
    return !text.empty() && text.size() <= kLongest &&
           std::all_of(text.begin(), text.end(), [](char c) {
               return is_letter(c) || is_digit(c) || c == '_' || c == '.' || c == '-';
           });
}

std::string fault_of_code(std::string_view text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos || !is_authority(text.substr(0, colon)))
        return "not understood";
    const std::string_view codes = text.substr(colon + 1);
    const std::size_t plus = codes.find('+');  // a horizontal and a vertical system
    const bool good = plus == std::string_view::npos
                          ? is_code(codes)
                          : is_code(codes.substr(0, plus)) && is_code(codes.substr(plus + 1));
    return good ? "" : "not understood";
}

// ---- PROJ strings ----

bool is_proj_parameter(std::string_view name) {
    constexpr auto kParameters = std::to_array<std::string_view>(
        {"proj",     "ellps",  "datum",     "a",       "b",      "rf",     "f",       "es",
         "e",        "R",      "R_A",       "R_V",     "R_a",    "R_g",    "R_h",     "units",
         "to_meter", "vunits", "vto_meter", "zone",    "south",  "lat_0",  "lat_1",   "lat_2",
         "lat_3",    "lat_ts", "lat_b",     "lon_0",   "lon_1",  "lon_2",  "lon_3",   "lonc",
         "lon_wrap", "alpha",  "gamma",     "azi",     "x_0",    "y_0",    "z_0",     "k",
         "k_0",      "pm",     "towgs84",   "no_defs", "wktext", "type",   "over",    "axis",
         "no_uoff",  "no_off", "h",         "sweep",   "approx", "algo",   "W",       "M",
         "m",        "n",      "q",         "theta",   "tilt",   "o_proj", "o_lat_p", "o_lon_p",
         "o_alpha",  "czech"});
    return is_among(kParameters, name);
}

std::string fault_of_proj_parameter(std::string_view word) {
    if (word.starts_with('+'))
        word.remove_prefix(1);
    const std::size_t equals = word.find('=');
    const std::string_view name = word.substr(0, equals);
    const std::string_view value =
        equals == std::string_view::npos ? std::string_view() : word.substr(equals + 1);
    if (name == "nadgrids" && value == "@null")
        return "";  // not a grid; part of every Web Mercator
    if (!is_proj_parameter(name))
        return "the PROJ parameter " + in_quotes(name) + " is none of those that name no file";
    return is_plain(value) ? ""
                           : "the PROJ parameter " + in_quotes(name) + " = " + in_quotes(value) +
                                 " is no number and no word";
}

std::string fault_of_proj(std::string_view text) {
    while (!(text = without_blanks(text)).empty()) {
        const auto end = std::find_if(text.begin(), text.end(), is_blank);
        const auto length = static_cast<std::size_t>(end - text.begin());
        if (std::string fault = fault_of_proj_parameter(text.substr(0, length)); !fault.empty())
            return fault;
        text.remove_prefix(length);
    }
    return "";
}

// ---- well-known text ----

bool is_keyword(std::string_view word) {
    constexpr auto kKeywords = std::to_array<std::string_view>(
        {// Version 1, also as ESRI writes it.
         "PROJCS", "GEOGCS", "GEOCCS", "COMPD_CS", "VERT_CS", "VERTCS", "LOCAL_CS", "VERT_DATUM",
         "LOCAL_DATUM", "SPHEROID", "PRIMEM", "UNIT", "LINUNIT", "PROJECTION", "PARAMETER", "AXIS",
         "AUTHORITY", "TOWGS84", "EXTENSION", "METADATA",
         // Version 2 (ISO 19162).
         "PROJCRS", "PROJECTEDCRS", "BASEPROJCRS", "DERIVEDPROJCRS", "GEOGCRS", "GEOGRAPHICCRS",
         "BASEGEOGCRS", "GEODCRS", "GEODETICCRS", "BASEGEODCRS", "VERTCRS", "VERTICALCRS",
         "BASEVERTCRS", "COMPOUNDCRS", "BOUNDCRS", "SOURCECRS", "TARGETCRS",
         "ABRIDGEDTRANSFORMATION", "ENGCRS", "ENGINEERINGCRS", "BASEENGCRS", "EDATUM",
         "ENGINEERINGDATUM", "DATUM", "GEODETICDATUM", "TRF", "GEODETICREFERENCEFRAME", "VDATUM",
         "VERTICALDATUM", "VRF", "VERTICALREFERENCEFRAME", "ENSEMBLE", "MEMBER", "ENSEMBLEACCURACY",
         "DYNAMIC", "FRAMEEPOCH", "MODEL", "VELOCITYGRID", "ANCHOR", "ANCHOREPOCH", "ELLIPSOID",
         "PRIMEMERIDIAN", "CS", "ORDER", "MERIDIAN", "BEARING", "AXISMINVALUE", "AXISMAXVALUE",
         "RANGEMEANING", "LENGTHUNIT", "ANGLEUNIT", "SCALEUNIT", "TIMEUNIT", "CONVERSION",
         "DERIVINGCONVERSION", "METHOD", "PARAMETERFILE", "OPERATIONACCURACY", "ID", "CITATION",
         "URI", "SCOPE", "AREA", "BBOX", "USAGE", "VERTICALEXTENT", "TIMEEXTENT", "REMARK",
         "VERSION", "GEOIDMODEL", "COORDINATEMETADATA", "EPOCH", "DEFININGTRANSFORMATION",
         "TEMPORALQUANTITY"});
    return is_among(kKeywords, word);
}

/// A keyword with the content of its brackets, excluding nested nodes.
struct Node {
    std::string keyword;  ///< upper case
    char closing = ']';
    std::vector<std::string> values;  ///< strings and bare words, in order
    std::vector<std::string> ids;     ///< of ID[...] in it: "EPSG:8666"
    [[nodiscard]] std::string_view value(std::size_t index) const noexcept {
        return index < values.size() ? std::string_view(values[index]) : std::string_view();
    }
};

/// PROJ interprets methods that begin with these words as PROJ strings: METHOD["PROJ ob_tran
/// o_proj=longlat ..."].
std::string fault_of_method(std::string_view name) {
    constexpr std::string_view kOwn = "PROJ";
    if (upper(name.substr(0, kOwn.size())) != kOwn)
        return "";
    name.remove_prefix(kOwn.size());
    if (!name.starts_with(' '))
        return "the method " + in_quotes(name) + " is an operation of PROJ's own";
    name = without_blanks(name);
    // The first word is the projection; where it is not, the rest cannot name a file either.
    return fault_of_proj("proj=" + std::string(name));
}

std::string fault_of_extension(const Node& node, std::string_view parent) {
    const std::string_view kind = node.value(0);
    const std::string_view value = node.value(1);
    if (kind == "PROJ4")
        return fault_of_proj(value);
    const bool vertical = parent == "VERT_DATUM" || parent == "VDATUM";
    if (kind == "PROJ4_GRIDS" && (value == "@null" || (vertical && is_plain(value))))
        return "";
    return "the extension " + in_quotes(kind) + " names " + in_quotes(value);
}

/// PROJ identifies the parameter by its code, else by its name: both must be the geoid's.
std::string fault_of_parameter_file(const Node& node) {
    const bool coded = node.ids.empty() || (node.ids.size() == 1 && node.ids[0] == "EPSG:8666");
    const bool geoid = node.value(0) == "Geoid (height correction) model file" && coded;
    return geoid && is_plain(node.value(1)) ? ""
                                            : "the parameter " + in_quotes(node.value(0)) +
                                                  " names the file " + in_quotes(node.value(1));
}

/// @param parent keyword of the enclosing node, upper case; empty: none
std::string fault_of_node(const Node& node, std::string_view parent) {
    if (!is_keyword(node.keyword))
        return "the keyword " + in_quotes(node.keyword) + " is not known";
    if (node.keyword == "EXTENSION")
        return fault_of_extension(node, parent);
    if (node.keyword == "METHOD" || node.keyword == "PROJECTION")
        return fault_of_method(node.value(0));
    if (node.keyword == "PARAMETERFILE")
        return fault_of_parameter_file(node);
    if (node.keyword == "GEOIDMODEL" && upper(node.value(0).substr(0, 4)) == "PROJ")
        return "the geoid model " + in_quotes(node.value(0)) + " names a file";
    return "";
}

/// Reads WKT from its first byte to its last, once. Everything that is neither a keyword with
/// brackets, a quoted string, a bare word nor a comma is a fault.
class WktReader {
public:
    explicit WktReader(std::string_view text) noexcept : m_rest(text) {}

    std::string fault() {
        constexpr const char* kNoWkt = "no well-known text";
        while (!(m_rest = without_blanks(m_rest)).empty()) {
            if (m_began && m_open.empty())
                return kNoWkt;  // trailing text
            const char c = m_rest.front();
            std::string wrong;
            if (c == '"')
                wrong = take_string();
            else if (c == ',')
                wrong = take_comma();
            else if (c == ']' || c == ')')
                wrong = take_end();
            else
                wrong = take_word();
            if (!wrong.empty())
                return wrong;
        }
        return m_began && m_open.empty() ? "" : kNoWkt;
    }

private:
    static constexpr std::size_t kMaxDepth = 16;  // nesting of nodes: PROJ's own limit

    std::string take_string() {
        if (m_open.empty())
            return "a text outside of brackets";
        std::string out;
        for (m_rest.remove_prefix(1); !m_rest.empty(); m_rest.remove_prefix(1)) {
            if (m_rest.front() == '"') {
                if (!m_rest.starts_with("\"\""))
                    break;
                m_rest.remove_prefix(1);  // a doubled quotation mark stands for one
            }
            out += m_rest.front();
        }
        if (m_rest.empty())
            return "a text without an end";
        m_rest.remove_prefix(1);
        m_open.back().values.push_back(std::move(out));
        return "";
    }

    std::string take_comma() {
        if (m_open.empty())
            return "a comma outside of brackets";
        m_rest.remove_prefix(1);
        return "";
    }

    std::string take_end() {
        if (m_open.empty() || m_rest.front() != m_open.back().closing)
            return "brackets that do not match";
        m_rest.remove_prefix(1);
        const Node node = std::move(m_open.back());
        m_open.pop_back();
        if (m_open.empty())
            return fault_of_node(node, {});
        if (node.keyword == "ID")
            m_open.back().ids.push_back(std::string(node.value(0)) + ":" +
                                        std::string(node.value(1)));
        return fault_of_node(node, m_open.back().keyword);
    }

    // A keyword when a bracket follows, else a number or a name such as "east".
    std::string take_word() {
        const auto is_of_word = [](char c) {
            return is_letter(c) || is_digit(c) || c == '_' || c == '.' || c == '+' || c == '-' ||
                   c == ':';
        };
        const auto end = std::find_if_not(m_rest.begin(), m_rest.end(), is_of_word);
        const auto length = static_cast<std::size_t>(end - m_rest.begin());
        if (length == 0)
            return "a character that stands in no well-known text";
        const std::string_view word = m_rest.substr(0, length);
        m_rest.remove_prefix(length);
        m_rest = without_blanks(m_rest);
        const bool opens = m_rest.starts_with('[') || m_rest.starts_with('(');
        if (!opens && m_open.empty())
            return "a word outside of brackets";
        if (!opens) {
            m_open.back().values.emplace_back(word);
            return "";
        }
        if (m_open.size() >= kMaxDepth)
            return "nested deeper than " + std::to_string(kMaxDepth);
        m_open.push_back({upper(word), m_rest.front() == '[' ? ']' : ')', {}, {}});
        m_began = true;
        m_rest.remove_prefix(1);
        return "";
    }

    std::string_view m_rest;
    std::vector<Node> m_open;  ///< the outermost first
    bool m_began = false;
};

}  // namespace

CrsNotation find_notation(std::string_view text) noexcept {
    text = without_blanks(text);
    const std::size_t mark = text.find_first_of("[(:=+");
    if (mark == std::string_view::npos || text[mark] == ':')
        return CrsNotation::kCode;
    return text[mark] == '[' || text[mark] == '(' ? CrsNotation::kWkt : CrsNotation::kProj;
}

std::string fault_of_crs_text(std::string_view text) {
    if (text.size() > kLongestCrsText)
        return std::to_string(text.size()) + " bytes, more than " + std::to_string(kLongestCrsText);
    const bool has_control = std::any_of(text.begin(), text.end(), [](char c) {
        return static_cast<unsigned char>(c) < ' ' && !is_blank(c);
    });
    if (without_blanks(text).empty() || has_control)
        return "not understood";
    switch (find_notation(text)) {
        case CrsNotation::kWkt: return WktReader(text).fault();
        case CrsNotation::kProj: return fault_of_proj(text);
        case CrsNotation::kCode: break;
    }
    return fault_of_code(without_blanks(text));
}

}  // namespace terravox::geo
