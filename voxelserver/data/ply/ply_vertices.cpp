#include "voxelserver/data/ply/ply_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::ply {
namespace {

using pointcloud::FileBytes;
using pointcloud::Point;
using Values = std::array<double, kFields>;

constexpr std::size_t kBufferBytes = 64 * 1024;
constexpr std::uint8_t kUnclassified = 1;

/// Validates the values of a vertex and converts them to a point.
class Checker {
public:
    Checker(const FileBytes& file, const Header& header) : m_file(file), m_header(header) {}

    void read_point(const Values& values, std::uint64_t vertex, Point& to) const {
        for (const Field axis : {kX, kY, kZ}) {
            if (!std::isfinite(values[axis]))
                fail(axis, values[axis], vertex, "allowed: finite numbers");
        }
        to = {};
        to.x = values[kX];
        to.y = values[kY];
        to.z = values[kZ];
        to.classification = kUnclassified;
        if (m_header.fields[kClass])
            to.classification = whole<std::uint8_t>(kClass, values, vertex);
        if (m_header.fields[kReturnNumber])
            to.return_number = whole<std::uint8_t>(kReturnNumber, values, vertex);
        if (m_header.fields[kReturnCount])
            to.return_count = whole<std::uint8_t>(kReturnCount, values, vertex);
        if (!m_header.has_colour())
            return;
        const bool bytes = m_header.properties[*m_header.fields[kRed]].type == Scalar::kUint8;
        for (const Field channel : {kRed, kGreen, kBlue}) {
            to.rgb[static_cast<std::size_t>(channel - kRed)] =
                bytes ? whole<std::uint8_t>(channel, values, vertex)
                      : whole<std::uint16_t>(channel, values, vertex);
        }
    }

private:
    template <class T>
    [[nodiscard]] T whole(Field field, const Values& values, std::uint64_t vertex) const {
        constexpr double kMax = std::numeric_limits<T>::max();
        const double value = values[field];
        if (!(value >= 0 && value <= kMax && value == std::floor(value)))
            fail(field, value, vertex,
                 "allowed: whole numbers from 0 to " + std::to_string(static_cast<int>(kMax)));
        return static_cast<T>(value);
    }

    [[noreturn]] void fail(Field field, double value, std::uint64_t vertex,
                           const std::string& allowed) const {
        m_file.fail("point " + std::to_string(vertex) + ": " +
                    m_header.properties[*m_header.fields[field]].name + " = " +
                    std::to_string(value) + "; " + allowed);
    }

    const FileBytes& m_file;
    const Header& m_header;
};

template <class T>
double number_at(const unsigned char* bytes, bool swap) noexcept {
    std::array<unsigned char, sizeof(T)> own;
    std::copy_n(bytes, sizeof(T), own.begin());
    if (swap)
        std::reverse(own.begin(), own.end());
    return static_cast<double>(std::bit_cast<T>(own));
}

double number_at(const unsigned char* bytes, Scalar type, bool swap) noexcept {
    switch (type) {
        case Scalar::kInt8: return number_at<std::int8_t>(bytes, swap);
        case Scalar::kUint8: return number_at<std::uint8_t>(bytes, swap);
        case Scalar::kInt16: return number_at<std::int16_t>(bytes, swap);
        case Scalar::kUint16: return number_at<std::uint16_t>(bytes, swap);
        case Scalar::kInt32: return number_at<std::int32_t>(bytes, swap);
        case Scalar::kUint32: return number_at<std::uint32_t>(bytes, swap);
        case Scalar::kFloat32: return number_at<float>(bytes, swap);
        case Scalar::kFloat64: return number_at<double>(bytes, swap);
    }
    return 0;
}

class BinaryReader final : public VertexReader {
public:
    BinaryReader(const FileBytes& file, const Header& header)
        : m_file(file),
          m_header(header),
          m_checker(file, header),
          m_swap(header.encoding == Encoding::kBigEndian) {}

    void seek(std::uint64_t /*byte*/, std::uint64_t /*number*/, std::uint64_t vertex) override {
        m_vertex = vertex;
        m_held = 0;
    }
    [[nodiscard]] std::uint64_t at_byte() const override {
        return m_header.data_at + m_vertex * m_header.record_bytes;
    }
    void next(Point& to) override {
        if (m_held == 0)
            fill();
        const unsigned char* const record = m_buffer.data() + m_buffer.size() - m_held;
        Values values{};
        for (std::size_t f = 0; f < kFields; ++f) {
            if (const auto index = m_header.fields[f]) {
                const Property& property = m_header.properties[*index];
                values[f] = number_at(record + property.offset, property.type, m_swap);
            }
        }
        m_checker.read_point(values, m_vertex, to);
        m_held -= m_header.record_bytes;
        ++m_vertex;
    }

private:
    void fill() {
        const std::uint64_t records =
            std::min<std::uint64_t>(std::max<std::size_t>(1, kBufferBytes / m_header.record_bytes),
                                    m_header.vertex_count - m_vertex);
        m_buffer.resize(static_cast<std::size_t>(records * m_header.record_bytes));
        m_file.read(at_byte(), m_buffer);
        m_held = m_buffer.size();
    }

    const FileBytes& m_file;
    const Header& m_header;
    const Checker m_checker;
    const bool m_swap;
    std::vector<unsigned char> m_buffer;
    std::size_t m_held = 0;  ///< unused bytes at the end of the buffer
    std::uint64_t m_vertex = 0;
};

class TextReader final : public VertexReader {
public:
    TextReader(const FileBytes& file, const Header& header)
        : m_file(file), m_checker(file, header), m_from(header.data_at) {
        m_field_of.resize(header.properties.size(), kFields);
        for (std::size_t f = 0; f < kFields; ++f) {
            if (const auto index = header.fields[f])
                m_field_of[*index] = static_cast<Field>(f);
        }
    }

    void seek(std::uint64_t byte, std::uint64_t number, std::uint64_t vertex) override {
        m_from = byte;
        m_text.clear();
        m_used = 0;
        for (m_vertex = number; m_vertex < vertex; ++m_vertex)
            static_cast<void>(next_line());
    }
    [[nodiscard]] std::uint64_t at_byte() const override { return m_from + m_used; }
    void next(Point& to) override {
        const std::string_view line = next_line();
        Values values{};
        std::size_t at = 0;
        for (const Field field : m_field_of) {
            const std::string_view word = to_word(line, at);
            if (word.empty())
                fail("has fewer than " + std::to_string(m_field_of.size()) + " numbers");
            if (field != kFields)
                values[field] = to_number(word);
        }
        if (!to_word(line, at).empty())
            fail("has more than " + std::to_string(m_field_of.size()) + " numbers");
        m_checker.read_point(values, m_vertex, to);
        ++m_vertex;
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        m_file.fail("the line of point " + std::to_string(m_vertex) + " " + what);
    }

    std::string_view next_line() {
        std::size_t end = m_text.find('\n', m_used);
        if (end == std::string::npos) {
            fill();
            end = m_text.find('\n', m_used);
        }
        if (end == std::string::npos) {
            if (m_from + m_text.size() < m_file.size())
                fail("is longer than " + std::to_string(kBufferBytes) + " bytes");
            end = m_text.size();  // the last line may lack a line end
        }
        if (end == m_used && m_from + m_used >= m_file.size())
            fail("is missing: the file is cut short");
        const std::string_view line(m_text.data() + m_used, end - m_used);
        m_used = std::min(end + 1, m_text.size());
        return line;
    }

    // Moves unused bytes to the front, and reads more after them.
    void fill() {
        m_text.erase(0, m_used);
        m_from += m_used;
        m_used = 0;
        const std::size_t held = m_text.size();
        const std::uint64_t at = m_from + held;
        const std::uint64_t more =
            std::min<std::uint64_t>(m_file.size() - std::min(at, m_file.size()),
                                    kBufferBytes - std::min(held, kBufferBytes));
        m_text.resize(held + static_cast<std::size_t>(more));
        m_file.read(at, {reinterpret_cast<unsigned char*>(m_text.data()) + held,
                         static_cast<std::size_t>(more)});
    }

    static std::string_view to_word(std::string_view line, std::size_t& at) {
        constexpr std::string_view kSpace = " \t\r";
        const std::size_t begin = std::min(line.find_first_not_of(kSpace, at), line.size());
        const std::size_t end = std::min(line.find_first_of(kSpace, begin), line.size());
        at = end;
        return line.substr(begin, end - begin);
    }

    [[nodiscard]] double to_number(std::string_view word) const {
        const std::string_view digits = word.substr(word.starts_with('+') ? 1 : 0);
        double out = 0;
        const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), out);
        if (read.ec != std::errc() || read.ptr != digits.data() + digits.size()) {
            constexpr std::size_t kShown = 40;
            fail("holds '" + std::string(word.substr(0, kShown)) + "'; allowed: numbers");
        }
        return out;
    }

    const FileBytes& m_file;
    const Checker m_checker;
    std::vector<Field> m_field_of;  ///< of each property; kFields: not read
    std::uint64_t m_from;           ///< file offset of the beginning of the text
    std::string m_text;
    std::size_t m_used = 0;  ///< bytes of the text used so far
    std::uint64_t m_vertex = 0;
};

}  // namespace

std::unique_ptr<VertexReader> open_vertices(const FileBytes& file, const Header& header) {
    if (header.encoding == Encoding::kAscii)
        return std::make_unique<TextReader>(file, header);
    return std::make_unique<BinaryReader>(file, header);
}

}  // namespace terravox::ply
