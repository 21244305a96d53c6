#include "voxelserver/make/voxelize/points/known_squares.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "common/voxel/fingerprint.hpp"

namespace terravox::voxelize {
namespace {

using voxel::ByteReader;
using voxel::ByteWriter;

/// The last character is the version of the layout.
constexpr std::string_view kMagic = "TVKNOWN2";
/// To be raised when opening finds something else in the same files.
constexpr std::uint32_t kOpeningRecipe = 2;

constexpr std::size_t kRectBytes = 4 * sizeof(double);
constexpr std::size_t kLineBytes = sizeof(std::uint16_t) + sizeof(double);
constexpr std::size_t kSquareBytes = 270;  ///< at least

util::Error failure(const std::string& what) {
    return util::Error("read what is known of squares: " + what);
}

void put(ByteWriter& out, const std::array<double, 3>& values) {
    for (const double v : values)
        out.add(v);
}
std::array<double, 3> three(ByteReader& in) {
    std::array<double, 3> out{};
    for (double& v : out)
        v = in.get<double>();
    return out;
}

bool flag(ByteReader& in) {
    return in.get<std::uint8_t>() != 0;
}

/// The CRSs of a list of squares: thousands of files have the same one, and parsing takes longer
/// than all else.
class CrsList {
public:
    std::uint32_t add(const std::string& wkt) {
        const auto [found, is_new] =
            m_numbers.emplace(wkt, static_cast<std::uint32_t>(m_texts.size()));
        if (is_new)
            m_texts.push_back(wkt);
        return found->second;
    }
    [[nodiscard]] const std::vector<std::string>& texts() const noexcept { return m_texts; }

    /// Whether the CRS is the same once it has been written and read.
    bool survives(const std::string& wkt) {
        const auto [found, is_new] = m_survives.emplace(wkt, false);
        if (is_new)
            found->second = survives_reading(wkt);
        return found->second;
    }

private:
    static bool survives_reading(const std::string& wkt) {
        try {
            return wkt.empty() || geo::Crs::from_wkt(wkt).wkt() == wkt;
        } catch (const util::Error&) {
            return false;
        }
    }
    std::map<std::string, std::uint32_t> m_numbers;
    std::map<std::string, bool> m_survives;
    std::vector<std::string> m_texts;
};

struct Texts {
    std::string stated;
    std::string placed;
};

void put(ByteWriter& out, const KnownSquare& square, CrsList& crs, const Texts& texts) {
    const pointcloud::PointCloudInfo& stated = square.stated;
    out.add(square.identity);
    out.add(square.side_identity);
    out.add(stated.file_bytes);
    out.add(stated.point_count);
    for (const auto* values : {&stated.scale, &stated.offset, &stated.min, &stated.max})
        put(out, *values);
    out.add(static_cast<std::uint8_t>(stated.measured_bounds));
    out.add(crs.add(texts.stated));
    out.add(crs.add(texts.placed));
    put(out, square.min);
    put(out, square.max);
    out.add(static_cast<std::uint64_t>(square.islands.size()));
    for (const PlanRect& rect : square.islands)
        for (const double v : {rect.min_x, rect.min_y, rect.max_x, rect.max_y})
            out.add(v);
    out.add(square.low);
    out.add(square.high);
    for (const bool is : {square.has_water, square.has_colour, square.has_index, square.has_echoes})
        out.add(static_cast<std::uint8_t>(is));
    out.add(static_cast<std::int32_t>(square.colour_shift));
    out.add(square.scale_from);
    out.add(static_cast<std::uint64_t>(square.brightness.lines().size()));
    for (const BrightnessScale::Line& line : square.brightness.lines()) {
        out.add(line.number);
        out.add(line.bright_ground);
    }
    for (const std::int32_t v :
         {square.bounds.min_x, square.bounds.min_z, square.bounds.max_x, square.bounds.max_z})
        out.add(v);
}

const std::string& text_at(const std::vector<std::string>& texts, std::uint32_t number) {
    if (number >= texts.size())
        throw failure("damaged");
    return texts[number];
}

KnownSquare find_square(ByteReader& in, const std::vector<std::string>& texts,
                        const std::vector<std::optional<geo::Crs>>& parsed) {
    KnownSquare out;
    out.identity = in.fingerprint();
    out.side_identity = in.fingerprint();
    out.stated.file_bytes = in.get<std::uint64_t>();
    out.stated.point_count = in.get<std::uint64_t>();
    for (auto* values : {&out.stated.scale, &out.stated.offset, &out.stated.min, &out.stated.max})
        *values = three(in);
    out.stated.measured_bounds = flag(in);
    const auto stated = in.get<std::uint32_t>();
    (void)text_at(texts, stated);
    out.stated.crs = parsed[stated];
    out.crs_wkt = text_at(texts, in.get<std::uint32_t>());
    out.min = three(in);
    out.max = three(in);
    out.islands.resize(in.count(kRectBytes));
    for (PlanRect& rect : out.islands)
        for (double* v : {&rect.min_x, &rect.min_y, &rect.max_x, &rect.max_y})
            *v = in.get<double>();
    out.low = in.get<double>();
    out.high = in.get<double>();
    for (bool* is : {&out.has_water, &out.has_colour, &out.has_index, &out.has_echoes})
        *is = flag(in);
    out.colour_shift = in.get<std::int32_t>();
    out.scale_from = in.fingerprint();
    std::vector<BrightnessScale::Line> lines(in.count(kLineBytes));
    for (BrightnessScale::Line& line : lines) {
        line.number = in.get<std::uint16_t>();
        line.bright_ground = in.get<double>();
    }
    out.brightness = BrightnessScale(std::move(lines));
    for (std::int32_t* v :
         {&out.bounds.min_x, &out.bounds.min_z, &out.bounds.max_x, &out.bounds.max_z})
        *v = in.get<std::int32_t>();
    return out;
}

bool is_sound(const PlanRect& rect) {
    return std::isfinite(rect.min_x) && std::isfinite(rect.min_y) && rect.min_x <= rect.max_x &&
           rect.min_y <= rect.max_y && std::isfinite(rect.max_x) && std::isfinite(rect.max_y);
}

bool is_sound(const grid::ColumnRect& rect) {
    constexpr std::int32_t kFarthest = 1 << 30;
    return rect.min_x < rect.max_x && rect.min_z < rect.max_z && rect.min_x > -kFarthest &&
           rect.min_z > -kFarthest && rect.max_x < kFarthest && rect.max_z < kFarthest;
}

/// Whether the lines ascend, each with something that intensities can be divided by.
bool is_sound(std::span<const BrightnessScale::Line> lines) {
    for (std::size_t i = 0; i < lines.size(); ++i)
        if (!(lines[i].bright_ground > 0) || !std::isfinite(lines[i].bright_ground) ||
            (i > 0 && lines[i - 1].number >= lines[i].number))
            return false;
    return true;
}

/// A checksum detects damage, not malice: values that would break arithmetic are refused.
bool is_sound(const KnownSquare& square) {
    constexpr double kFarthest = 1e9;  // of heights, in units of any kind
    if (square.stated.point_count == 0 || square.islands.empty() ||
        (square.colour_shift != 0 && square.colour_shift != 8))
        return false;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto& stated = square.stated;
        if (!(square.min[a] <= square.max[a]) || !std::isfinite(square.max[a] - square.min[a]) ||
            !(stated.min[a] <= stated.max[a]) || !std::isfinite(stated.max[a] - stated.min[a]) ||
            !std::isfinite(stated.scale[a]) || !std::isfinite(stated.offset[a]))
            return false;
    }
    return std::abs(square.low) < kFarthest && std::abs(square.high) < kFarthest &&
           square.low <= square.high && is_sound(square.bounds) &&
           is_sound(square.brightness.lines()) &&
           std::all_of(
               square.islands.begin(), square.islands.end(),
               [](const PlanRect& rect) { return is_sound(rect); });
}

/// The inverse of voxel::to_hex().
std::optional<voxel::Fingerprint> to_fingerprint(std::string_view digits) {
    constexpr std::size_t kDigits = 16;
    voxel::Fingerprint out{};
    if (digits.size() != kDigits * out.size())
        return std::nullopt;
    for (std::uint64_t& half : out) {
        const char* const end = digits.data() + kDigits;
        const auto read = std::from_chars(digits.data(), end, half, 16);
        if (read.ec != std::errc{} || read.ptr != end)
            return std::nullopt;
        digits.remove_prefix(kDigits);
    }
    return out;
}

}  // namespace

template <class Wanted>
const KnownSquare* KnownSquares::first(const voxel::Fingerprint& identity,
                                       const Wanted& wanted) const {
    const auto [begin, end] = m_by_identity.equal_range(identity[0]);
    std::size_t out = m_squares.size();
    for (auto at = begin; at != end; ++at)
        if (m_squares[at->second].identity == identity && wanted(m_squares[at->second]))
            out = std::min(out, at->second);
    return out < m_squares.size() ? &m_squares[out] : nullptr;
}

const KnownSquare* KnownSquares::find(const voxel::Fingerprint& identity,
                                      const voxel::Fingerprint& side_identity) const {
    return first(identity,
                 [&](const KnownSquare& square) { return square.side_identity == side_identity; });
}

const KnownSquare* KnownSquares::find(const voxel::Fingerprint& identity) const {
    return first(identity, [](const KnownSquare&) { return true; });
}

const KnownSquare* KnownSquares::find(std::string_view identity) const {
    const auto print = to_fingerprint(identity);
    return print ? find(*print) : nullptr;
}

void KnownSquares::add(KnownSquare square) {
    m_by_identity.emplace(square.identity[0], m_squares.size());
    m_squares.push_back(std::move(square));
}

std::string KnownSquares::to_bytes(const voxel::Fingerprint& way) const {
    CrsList crs;
    ByteWriter squares;
    std::uint64_t count = 0;
    for (const KnownSquare& square : m_squares) {
        const Texts texts{square.stated.crs ? square.stated.crs->wkt() : "", square.crs_wkt};
        if (!crs.survives(texts.stated) || !crs.survives(texts.placed))
            continue;
        put(squares, square, crs, texts);
        ++count;
    }
    ByteWriter out;
    out.add(way);
    out.add(roles);
    out.add(static_cast<std::uint64_t>(crs.texts().size()));
    for (const std::string& text : crs.texts())
        out.add(text);
    out.add(count);
    const std::string body = out.bytes() + squares.bytes();
    ByteWriter checksum;
    checksum.add(voxel::to_fingerprint(body));
    return std::string(kMagic) + checksum.bytes() + body;
}

KnownSquares KnownSquares::from_bytes(std::string_view bytes, const voxel::Fingerprint& way) {
    if (!bytes.starts_with(kMagic))
        throw failure("another version, or no facts");
    bytes.remove_prefix(kMagic.size());
    ByteReader head(bytes);
    const voxel::Fingerprint said = head.fingerprint();
    if (!head.ok())
        throw failure("cut short");
    bytes.remove_prefix(sizeof said);
    if (voxel::to_fingerprint(bytes) != said)
        throw failure("damaged (checksum)");
    ByteReader in(bytes);
    if (in.fingerprint() != way)
        throw failure("found by another program, or with other filters");
    const voxel::Fingerprint roles = in.fingerprint();
    std::vector<std::string> texts(in.count(sizeof(std::uint64_t)));
    std::vector<std::optional<geo::Crs>> parsed;
    for (std::string& text : texts) {
        text = in.text();
        parsed.push_back(text.empty() ? std::nullopt : std::optional(geo::Crs::from_wkt(text)));
    }
    KnownSquares out;
    out.roles = roles;
    const std::size_t count = in.count(kSquareBytes);
    for (std::size_t i = 0; i < count && in.ok(); ++i) {
        KnownSquare square = find_square(in, texts, parsed);
        if (!in.ok() || !is_sound(square))
            throw failure("damaged");
        out.add(std::move(square));
    }
    if (!in.finished())
        throw failure("damaged");
    return out;
}

voxel::Fingerprint way_of_opening(const Settings::Points& filters) {
    ByteWriter out;
    out.add(std::string_view(kVersion));
    out.add(kOpeningRecipe);
    out.add(filters.drop_withheld);
    out.add(filters.drop_overlap);
    return out.fingerprint();
}

voxel::Fingerprint fingerprint_of_roles(const ClassTable& classes) {
    ByteWriter out;
    for (const ClassMeaning& meaning : classes.meaning)
        out.add(meaning.role);
    return out.fingerprint();
}

}  // namespace terravox::voxelize
