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
#include "voxelserver/make/voxelize/points/stored_facts.hpp"

namespace terravox::voxelize {
namespace {

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

/// What of a square is stored in another form.
struct StoredApart {
    std::uint32_t stated_crs = 0;  ///< numbers in CrsList
    std::uint32_t placed_crs = 0;
    std::vector<BrightnessScale::Line> lines;
};

/// Names the members for both ways (MaybeConst).
template <class Bytes>
void visit(Bytes& bytes, MaybeConst<KnownSquare> auto& square,
           MaybeConst<StoredApart> auto& apart) {
    auto& stated = square.stated;
    bytes.each(square.identity, square.side_identity, stated.file_bytes, stated.point_count,
               stated.scale, stated.offset, stated.min, stated.max, stated.measured_bounds,
               apart.stated_crs, apart.placed_crs, square.min, square.max);
    bytes.list(square.islands, kRectBytes,
               [&](auto& rect) { bytes.each(rect.min_x, rect.min_y, rect.max_x, rect.max_y); });
    bytes.each(square.low, square.high, square.has_water, square.has_colour, square.has_index,
               square.has_echoes, square.colour_shift, square.scale_from);
    bytes.list(apart.lines, kLineBytes,
               [&](auto& line) { bytes.each(line.number, line.bright_ground); });
    auto& bounds = square.bounds;
    bytes.each(bounds.min_x, bounds.min_z, bounds.max_x, bounds.max_z);
}

const std::string& text_at(const std::vector<std::string>& texts, std::uint32_t number) {
    if (number >= texts.size())
        throw failure("damaged");
    return texts[number];
}

KnownSquare find_square(FactReader& in, const std::vector<std::string>& texts,
                        const std::vector<std::optional<geo::Crs>>& parsed) {
    KnownSquare out;
    StoredApart apart;
    visit(in, out, apart);
    out.crs_wkt = text_at(texts, apart.placed_crs);
    (void)text_at(texts, apart.stated_crs);
    out.stated.crs = parsed[apart.stated_crs];
    out.brightness = BrightnessScale(std::move(apart.lines));
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
    FactWriter squares;
    std::uint64_t count = 0;
    for (const KnownSquare& square : m_squares) {
        const std::string stated = square.stated.crs ? square.stated.crs->wkt() : "";
        if (!crs.survives(stated) || !crs.survives(square.crs_wkt))
            continue;
        const StoredApart apart{crs.add(stated), crs.add(square.crs_wkt),
                                square.brightness.lines()};
        visit(squares, square, apart);
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
    FactReader head(bytes);
    const voxel::Fingerprint said = head.fingerprint();
    if (!head.ok())
        throw failure("cut short");
    bytes.remove_prefix(sizeof said);
    if (voxel::to_fingerprint(bytes) != said)
        throw failure("damaged (checksum)");
    FactReader in(bytes);
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
