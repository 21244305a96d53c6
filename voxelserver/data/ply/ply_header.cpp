#include "voxelserver/data/ply/ply_file.hpp"

#include <algorithm>
#include <charconv>
#include <sstream>
#include <string_view>

#include "common/util/text.hpp"

namespace terravox::ply {
namespace {

using pointcloud::FileBytes;

constexpr std::uint64_t kMaxHeaderBytes = 64 * 1024;
constexpr std::size_t kMaxProperties = 256;

struct TypeName {
    std::string_view name;
    Scalar type;
};
constexpr std::array<TypeName, 16> kTypes{{
    {"char", Scalar::kInt8},
    {"int8", Scalar::kInt8},
    {"uchar", Scalar::kUint8},
    {"uint8", Scalar::kUint8},
    {"short", Scalar::kInt16},
    {"int16", Scalar::kInt16},
    {"ushort", Scalar::kUint16},
    {"uint16", Scalar::kUint16},
    {"int", Scalar::kInt32},
    {"int32", Scalar::kInt32},
    {"uint", Scalar::kUint32},
    {"uint32", Scalar::kUint32},
    {"float", Scalar::kFloat32},
    {"float32", Scalar::kFloat32},
    {"double", Scalar::kFloat64},
    {"float64", Scalar::kFloat64},
}};

struct FieldName {
    std::string_view name;  ///< as returned by plain_name()
    Field field;
};
constexpr std::array<FieldName, 21> kFieldNames{{
    {"x", kX},
    {"y", kY},
    {"z", kZ},
    {"red", kRed},
    {"green", kGreen},
    {"blue", kBlue},
    {"diffusered", kRed},
    {"diffusegreen", kGreen},
    {"diffuseblue", kBlue},
    {"r", kRed},
    {"g", kGreen},
    {"b", kBlue},
    {"classification", kClass},
    {"class", kClass},
    {"label", kClass},
    {"returnnumber", kReturnNumber},
    {"numberofreturns", kReturnCount},
    {"returncount", kReturnCount},
    {"returnnum", kReturnNumber},
    {"numreturns", kReturnCount},
    {"returns", kReturnCount},
}};

/// Normalises a property name, which programs write in different ways: return_number, ReturnNumber,
/// scalar_Return_Number (CloudCompare). Lower case, without these prefixes and underscores.
std::string plain_name(std::string_view name) {
    std::string out;
    for (const char c : name) {
        if (c != '_')
            out += util::lower_case(c);
    }
    constexpr std::string_view kPrefix = "scalar";
    if (out.starts_with(kPrefix))
        out.erase(0, kPrefix.size());
    return out;
}

std::vector<std::string> list_words(const std::string& line) {
    std::istringstream in(line);
    std::vector<std::string> out;
    for (std::string word; in >> word;)
        out.push_back(word);
    return out;
}

/// Reads a header line by line.
class HeaderParser {
public:
    explicit HeaderParser(const FileBytes& file) : m_file(file) {
        const std::uint64_t bytes = std::min(file.size(), kMaxHeaderBytes);
        std::vector<unsigned char> head(static_cast<std::size_t>(bytes));
        file.read(0, head);
        m_text.assign(head.begin(), head.end());
    }

    Header parse() {
        if (next_line() != "ply")
            m_file.fail("not a PLY file (its first line is not 'ply')");
        for (std::string line = next_line(); line != "end_header"; line = next_line())
            take(line);
        m_header.data_at = m_at;
        check_elements();
        find_fields();
        check_size();
        return std::move(m_header);
    }

private:
    struct Element {
        std::string name;
        std::uint64_t count = 0;
    };

    std::string next_line() {
        const std::size_t end = m_text.find('\n', m_at);
        if (end == std::string::npos) {
            m_file.fail(m_file.size() > kMaxHeaderBytes
                            ? "a header of more than 64 KiB without 'end_header'"
                            : "cut short: its header has no 'end_header'");
        }
        std::string line = m_text.substr(m_at, end - m_at);
        m_at = end + 1;
        if (line.ends_with('\r'))
            line.pop_back();
        return line;
    }

    [[noreturn]] void fail(const std::string& line, const std::string& why) const {
        constexpr std::size_t kShown = 80;
        m_file.fail("header line '" + line.substr(0, kShown) + "': " + why);
    }

    void take(const std::string& line) {
        const auto words = list_words(line);
        const std::string key = words.empty() ? "" : words.front();
        if (key == "format")
            take_format(line, words);
        else if (key == "element")
            take_element(line, words);
        else if (key == "property")
            take_property(line, words);
        else if (key == "comment")
            take_comment(line);
        else if (key != "obj_info")
            fail(line, "allowed: format, element, property, comment, obj_info, end_header");
    }

    void take_format(const std::string& line, const std::vector<std::string>& words) {
        const std::string kind = words.size() == 3 && words[2] == "1.0" ? words[1] : "";
        if (kind == "ascii")
            m_header.encoding = Encoding::kAscii;
        else if (kind == "binary_little_endian")
            m_header.encoding = Encoding::kLittleEndian;
        else if (kind == "binary_big_endian")
            m_header.encoding = Encoding::kBigEndian;
        else
            fail(line, "allowed: ascii, binary_little_endian or binary_big_endian, 1.0");
        m_has_format = true;
    }

    void take_element(const std::string& line, const std::vector<std::string>& words) {
        Element element;
        if (words.size() != 3)
            fail(line, "allowed: element NAME COUNT");
        element.name = words[1];
        const std::string& count = words[2];
        const char* const end = count.data() + count.size();
        const auto read = std::from_chars(count.data(), end, element.count);
        if (read.ec != std::errc() || read.ptr != end)
            fail(line, "the count is no whole number from 0");
        m_elements.push_back(std::move(element));
    }

    void take_property(const std::string& line, const std::vector<std::string>& words) {
        if (m_elements.empty())
            fail(line, "it belongs to no element");
        if (m_elements.size() > 1)
            return;  // of an element after the vertices, which is not read
        if (words.size() > 1 && words[1] == "list")
            fail(line, "a vertex of a point cloud has no list");
        if (words.size() != 3)
            fail(line, "allowed: property TYPE NAME");
        const auto type = std::find_if(kTypes.begin(), kTypes.end(),
                                       [&](const TypeName& t) { return t.name == words[1]; });
        if (type == kTypes.end())
            fail(line,
                 "unknown type; allowed: char, uchar, short, ushort, int, uint, float, double");
        if (m_header.properties.size() == kMaxProperties)
            fail(line, "more than " + std::to_string(kMaxProperties) + " properties");
        m_header.properties.push_back({words[2], type->type, m_header.record_bytes});
        m_header.record_bytes += measure_bytes(type->type);
    }

    // "comment crs EPSG:2154", "comment CRS: PROJCS[...]"
    void take_comment(const std::string& line) {
        constexpr std::string_view kKey = "comment crs";
        constexpr std::string_view kBetween = " \t:=";
        if (!util::lower_case(line).starts_with(kKey) || !m_header.crs.empty())
            return;
        const std::size_t begin = line.find_first_not_of(kBetween, kKey.size());
        if (begin != std::string::npos && begin > kKey.size())
            m_header.crs = line.substr(begin, line.find_last_not_of(" \t") + 1 - begin);
    }

    void check_elements() {
        if (!m_has_format)
            m_file.fail("its header has no line 'format'");
        if (m_elements.empty() || m_elements.front().name != "vertex")
            m_file.fail("its first element is " +
                        (m_elements.empty() ? "missing" : "'" + m_elements.front().name + "'") +
                        "; allowed: vertex");
        for (const Element& element : m_elements) {
            if (element.name == "face" && element.count > 0)
                m_file.fail("a mesh of " + std::to_string(element.count) +
                            " faces; allowed: point clouds, whose vertices are points");
        }
        m_header.vertex_count = m_elements.front().count;
    }

    void find_fields() {
        for (const FieldName& known : kFieldNames) {
            auto& field = m_header.fields[known.field];
            for (std::size_t i = 0; i < m_header.properties.size() && !field; ++i) {
                if (plain_name(m_header.properties[i].name) == known.name)
                    field = i;
            }
        }
        for (const Field axis : {kX, kY, kZ}) {
            if (!m_header.fields[axis])
                m_file.fail(std::string("its vertices have no property ") + "xyz"[axis]);
        }
        auto& fields = m_header.fields;
        if (!fields[kRed] || !fields[kGreen] || !fields[kBlue]) {
            fields[kRed].reset();
            fields[kGreen].reset();
            fields[kBlue].reset();
            return;
        }
        const Scalar type = m_header.properties[*fields[kRed]].type;
        for (const Field channel : {kRed, kGreen, kBlue}) {
            const Property& property = m_header.properties[*fields[channel]];
            if (property.type != type || (type != Scalar::kUint8 && type != Scalar::kUint16))
                m_file.fail("type of the colour '" + property.name +
                            "'; allowed: uchar or ushort, the same for red, green and blue");
        }
    }

    // Must precede any allocation or reading that depends on the count.
    void check_size() {
        const bool text = m_header.encoding == Encoding::kAscii;
        if (text)
            m_header.record_bytes = 0;
        // The shortest line of text has a digit and a separator for each property.
        const std::uint64_t least =
            text ? 2 * m_header.properties.size() : std::uint64_t{m_header.record_bytes};
        // The last line may lack a line end.
        const std::uint64_t held = (m_file.size() - m_header.data_at + (text ? 1 : 0)) / least;
        if (m_header.vertex_count > held)
            m_file.fail("cut short: " + std::to_string(m_header.vertex_count) +
                        " points promised; at most " + std::to_string(held) + " are there");
    }

    const FileBytes& m_file;
    std::string m_text;
    std::size_t m_at = 0;
    bool m_has_format = false;
    std::vector<Element> m_elements;
    Header m_header;
};

}  // namespace

std::uint32_t measure_bytes(Scalar type) noexcept {
    switch (type) {
        case Scalar::kInt8:
        case Scalar::kUint8: return 1;
        case Scalar::kInt16:
        case Scalar::kUint16: return 2;
        case Scalar::kInt32:
        case Scalar::kUint32:
        case Scalar::kFloat32: return 4;
        case Scalar::kFloat64: return 8;
    }
    return 8;
}

Header read_header(const FileBytes& file) {
    return HeaderParser(file).parse();
}

}  // namespace terravox::ply
