#include "voxelserver/make/voxelize/steps/photo_light.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "common/voxel/fingerprint.hpp"
#include "voxelserver/make/voxelize/points/stored_facts.hpp"

namespace terravox::voxelize {
namespace {

using grid::ColumnRect;
using grid::PatchRect;

constexpr int kMaxShadowPatches = 4;

std::int32_t find_part(std::int64_t length, std::int64_t i, std::int64_t count) noexcept {
    return static_cast<std::int32_t>(length * i / count);
}

/// An image in equal parts of about a kilometre.
class Parts {
public:
    Parts(const ColumnRect& image, double voxel_m) : m_image(image) {
        constexpr double kPart_m = 1000;
        const auto count = [&](std::int64_t columns) {
            return std::max<std::int64_t>(
                1, std::llround(static_cast<double>(columns) * voxel_m / kPart_m));
        };
        m_across = count(width());
        m_down = count(height());
    }
    [[nodiscard]] ColumnRect rect(std::int64_t x, std::int64_t z) const noexcept {
        return {m_image.min_x + find_part(width(), x, m_across),
                m_image.min_z + find_part(height(), z, m_down),
                m_image.min_x + find_part(width(), x + 1, m_across),
                m_image.min_z + find_part(height(), z + 1, m_down)};
    }

    /// The part of which files cover most, to an eighth; of several the one nearest to the middle
    /// of the image, the north-western one first. Does not depend on how files are cut.
    [[nodiscard]] ColumnRect best_covered(const Sources& sources) const {
        std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> covered;  // by z, x
        for (const SquareSource& file : sources.files) {
            const ColumnRect common = file.bounds.common(m_image);
            if (common.area() == 0)
                continue;
            for (std::int64_t z = find_row(common.min_z); z <= find_row(common.max_z - 1); ++z)
                for (std::int64_t x = find_column(common.min_x); x <= find_column(common.max_x - 1);
                     ++x)
                    covered[{z, x}] += common.common(rect(x, z)).area();
        }
        ColumnRect best{};
        std::int64_t best_eighths = -1;
        std::int64_t best_distance = 0;
        for (const auto& [place, area] : covered) {
            const auto& [z, x] = place;
            const ColumnRect here = rect(x, z);
            const std::int64_t eighths = (8 * area + here.area() / 2) / here.area();
            const std::int64_t distance =
                std::abs(2 * x + 1 - m_across) + std::abs(2 * z + 1 - m_down);
            if (eighths > best_eighths || (eighths == best_eighths && distance < best_distance)) {
                best = here;
                best_eighths = eighths;
                best_distance = distance;
            }
        }
        return best;
    }

private:
    [[nodiscard]] std::int64_t width() const noexcept {
        return std::int64_t{m_image.max_x} - m_image.min_x;
    }
    [[nodiscard]] std::int64_t height() const noexcept {
        return std::int64_t{m_image.max_z} - m_image.min_z;
    }
    // The last part that begins at or before a column.
    [[nodiscard]] std::int64_t find_column(std::int32_t x) const noexcept {
        return ((std::int64_t{x} - m_image.min_x + 1) * m_across - 1) / width();
    }
    [[nodiscard]] std::int64_t find_row(std::int32_t z) const noexcept {
        return ((std::int64_t{z} - m_image.min_z + 1) * m_down - 1) / height();
    }

    ColumnRect m_image;
    std::int64_t m_across = 1;
    std::int64_t m_down = 1;
};

/// The patches of a rectangle between the first and the last of which the middle lies in a file, or
/// a few columns next to it: files that a survey was cut into have gaps between their bounds.
std::optional<PatchRect> covered_patches(const ColumnRect& rect, const Sources& sources) {
    constexpr std::int32_t kGap = 8;
    std::vector<ColumnRect> near;
    for (const SquareSource& file : sources.files)
        if (file.bounds.grown(kGap).overlaps(rect))
            near.push_back(file.bounds.grown(kGap));
    std::optional<PatchRect> out;
    for (std::int32_t pz = rect.min_z >> 6; pz <= (rect.max_z - 1) >> 6; ++pz)
        for (std::int32_t px = rect.min_x >> 6; px <= (rect.max_x - 1) >> 6; ++px) {
            const std::int32_t x = px * grid::kPatchSize + grid::kPatchSize / 2;
            const std::int32_t z = pz * grid::kPatchSize + grid::kPatchSize / 2;
            const ColumnRect middle{x, z, x + 1, z + 1};
            if (std::none_of(near.begin(), near.end(),
                             [&](const ColumnRect& r) { return r.overlaps(middle); }))
                continue;
            if (!out)
                out = PatchRect{{px, pz}, {px + 1, pz + 1}};
            out->min = {std::min(out->min.px, px), out->min.pz};
            out->max = {std::max(out->max.px, px + 1), pz + 1};
        }
    return out;
}

/// The starts of blocks along one axis, in patches.
std::vector<std::int32_t> starts(std::int32_t first, std::int32_t end, int block, int most) {
    const int length = end - first;
    const int count = std::clamp(length / block, 1, most);
    std::vector<std::int32_t> out;
    for (int i = 0; i < count; ++i) {
        const int middle = static_cast<int>(std::int64_t{length} * (2 * i + 1) / (2 * count));
        out.push_back(first + std::clamp(middle - block / 2, 0, std::max(length - block, 0)));
    }
    return out;
}

}  // namespace

ExposureImages exposure_images(std::span<const imagery::Orthophotos::Input> images) {
    std::map<std::size_t, std::vector<std::pair<voxel::Fingerprint, std::size_t>>> all;
    for (std::size_t i = 0; i < images.size(); ++i) {
        // By its place, since a file that is copied gets another identity.
        const ColumnRect& rect = images[i].rect;
        voxel::ByteWriter place;
        for (const std::int32_t v : {rect.min_x, rect.min_z, rect.max_x, rect.max_z})
            place.add(v);
        all[images[i].series].emplace_back(place.fingerprint(), i);
    }
    ExposureImages out;
    for (auto& [number, series] : all) {
        const std::size_t count = std::min(series.size(), kExposureImages);
        std::partial_sort(series.begin(), series.begin() + static_cast<std::ptrdiff_t>(count),
                          series.end());
        for (std::size_t i = 0; i < count; ++i)
            out[number].push_back(series[i].second);
        std::sort(out[number].begin(), out[number].end());
    }
    return out;
}

int shadow_patches(double voxel_m) noexcept {
    constexpr double kReach_m = 60;
    // One patch around follows shadows of 55 voxels (kPatchSize - kEdgeReach): enough at 1 m.
    return std::clamp(static_cast<int>(std::lround(kReach_m / (grid::kPatchSize * voxel_m))), 1,
                      kMaxShadowPatches);
}

PhotoSample photo_sample(const ColumnRect& image, const Sources& sources) {
    PhotoSample out;
    if (image.area() == 0)
        return out;
    const double voxel_m = sources.frame.voxel_m();
    const ColumnRect part = Parts(image, voxel_m).best_covered(sources);
    if (part.area() == 0)
        return out;
    const auto covered = covered_patches(part, sources);
    if (!covered)
        return out;
    constexpr double kBlock_m = 128;
    constexpr double kFine_m = 0.75;
    const int block = std::clamp(
        static_cast<int>(std::ceil(kBlock_m / (grid::kPatchSize * voxel_m))), 1, kMaxShadowPatches);
    const int most = voxel_m < kFine_m ? 2 : 3;
    const int around = shadow_patches(voxel_m);
    std::vector<ColumnRect> read;
    for (const std::int32_t pz : starts(covered->min.pz, covered->max.pz, block, most))
        for (const std::int32_t px : starts(covered->min.px, covered->max.px, block, most)) {
            const PatchRect rect{
                {px, pz},
                {std::min(px + block, covered->max.px), std::min(pz + block, covered->max.pz)}};
            out.blocks.push_back(rect);
            read.push_back(
                ColumnRect{rect.min.x0(), rect.min.z0(), rect.max.x0(), rect.max.z0()}.grown(
                    around * grid::kPatchSize + 1));
        }
    for (std::size_t i = 0; i < sources.files.size(); ++i)
        if (std::any_of(read.begin(), read.end(),
                        [&](const ColumnRect& r) { return r.overlaps(sources.files[i].bounds); }))
            out.files.push_back(i);
    return out;
}

voxel::Fingerprint to_fingerprint(const PhotoSample& sample, const voxel::Fingerprint& identity,
                                  const Sources& sources) {
    voxel::ByteWriter out;
    out.add(identity);
    for (const PatchRect& block : sample.blocks)
        for (const std::int32_t v : {block.min.px, block.min.pz, block.max.px, block.max.pz})
            out.add(v);
    std::vector<voxel::Fingerprint> files;
    for (const std::size_t file : sample.files)
        files.push_back(to_fingerprint(sources.files[file]));
    std::sort(files.begin(), files.end());
    for (const voxel::Fingerprint& file : files)
        out.add(file);
    return out.fingerprint();
}

namespace {

/// To be raised when the layout changes.
constexpr std::uint32_t kVersion = 2;

/// Names the members for both ways (MaybeConst).
template <class Bytes>
void visit(Bytes& bytes, MaybeConst<PhotoLight> auto& found) {
    const auto visit_sun = [&](auto& sun) { bytes.each(sun.azimuth_deg, sun.altitude_deg); };
    auto& light = found.light;
    bytes.maybe(light.sun, visit_sun);
    bytes.each(light.sky, light.veil, light.gain, light.typical);
    visit_sun(found.estimate.sun);
    bytes.each(found.estimate.correlation, found.estimate.margin);
    for (auto& one : found.evidence.seen)
        bytes.each(one.albedo, one.cells);
    bytes.each(found.evidence.darkest, found.evidence.cells);
}

bool is_sound(const sunlight::Sun& sun) noexcept {
    return sun.azimuth_deg >= 0 && sun.azimuth_deg <= 360 && sun.altitude_deg > 0 &&
           sun.altitude_deg < 90;
}

bool all_within(const auto& values, float least, float most) noexcept {
    return std::all_of(values.begin(), values.end(),
                       [&](float v) { return v >= least && v <= most; });
}

/// Also false for values that are not numbers.
bool is_sound(const PhotoLight& found) noexcept {
    constexpr float kLeastSky = 0.01F;
    constexpr float kMost = 1e4F;
    constexpr double kMostCorrelation = 1.001;  // rounded
    const sunlight::FlightLight& light = found.light;
    const sunlight::SunEstimate& estimate = found.estimate;
    return (!light.sun || is_sound(*light.sun)) && is_sound(estimate.sun) &&
           estimate.correlation >= -kMostCorrelation && estimate.correlation <= kMostCorrelation &&
           estimate.margin >= 0 && estimate.margin <= 1 && all_within(light.sky, kLeastSky, 1) &&
           all_within(light.veil, 0, 1) && all_within(light.gain, 1 / kMost, kMost) &&
           all_within(light.typical, 0, kMost) &&
           std::all_of(found.evidence.seen.begin(), found.evidence.seen.end(),
                       [&](const sunlight::Sighting& one) {
                           return all_within(one.albedo, 0, kMost * kMost);
                       }) &&
           all_within(found.evidence.darkest, 0, kMost * kMost);
}

}  // namespace

std::string to_bytes(const PhotoLight& found) {
    FactWriter out;
    out.add(kVersion);
    visit(out, found);
    return out.bytes();
}

std::optional<PhotoLight> parse_photo_light(std::string_view bytes) {
    FactReader in(bytes);
    if (in.get<std::uint32_t>() != kVersion)
        return std::nullopt;
    PhotoLight out;
    visit(in, out);
    return in.finished() && is_sound(out) ? std::optional(out) : std::nullopt;
}

}  // namespace terravox::voxelize
