#include "voxelserver/data/sunlight/exposure.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "voxelserver/data/sunlight/sun.hpp"

namespace terravox::sunlight {
namespace {

constexpr std::size_t kRed = 0;
constexpr std::size_t kGreen = 1;
constexpr std::size_t kBlue = 2;

/// Less is chance.
constexpr std::uint32_t kChance = 16;

float value_at(std::vector<float>& values, double share) {
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

/// The values of a material, by channel.
class Values {
public:
    void add(const Light& value) {
        for (std::size_t c = 0; c < 3; ++c)
            m_values[c].push_back(value[c]);
    }
    [[nodiscard]] Sighting sighting(double share = 0.5) {
        Sighting out;
        out.cells = static_cast<std::uint32_t>(m_values[0].size());
        if (out.cells > 0)
            out.albedo = at(share);
        return out;
    }
    /// @param share of values that are lower; there is at least one
    [[nodiscard]] Light at(double share) {
        return {value_at(m_values[0], share), value_at(m_values[1], share),
                value_at(m_values[2], share)};
    }

private:
    std::array<std::vector<float>, 3> m_values;
};

/// @param most red or blue over green, or the reverse
bool is_grey(const Light& value, float most) noexcept {
    return value[kGreen] > 0 && std::max(value[kRed], value[kBlue]) < most * value[kGreen] &&
           std::min(value[kRed], value[kBlue]) * most > value[kGreen];
}

/// As it would look beside grey asphalt.
Light balanced(const Light& value, const Light& asphalt) noexcept {
    return {value[kRed] * asphalt[kGreen] / asphalt[kRed], value[kGreen],
            value[kBlue] * asphalt[kGreen] / asphalt[kBlue]};
}

bool is_tile_red(const Light& value) noexcept {
    constexpr float kRedOverGreen = 1.1F;
    return value[kRed] > kRedOverGreen * value[kGreen] && value[kGreen] > 0.9F * value[kBlue];
}

/// A scene with all that materials are told by.
struct Photographed {
    const Scene& scene;
    std::vector<Slope> slopes;
    std::vector<float> lit;
};

class KnownMaterials {
public:
    KnownMaterials(std::span<const Scene> scenes, const FlightLight& light) : m_light(light) {
        if (light.sun)
            m_facing.emplace(*light.sun);
        for (const Scene& scene : scenes) {
            m_parts.push_back({scene, measure_slopes(scene), {}});
            if (light.sun)
                m_parts.back().lit = lit_shares(scene, *light.sun);
            for (std::size_t i = 0; i < scene.cover.size(); ++i) {
                const bool ground = scene.kind[i] == Kind::kGround;
                m_ground_told |= ground && scene.cover[i] != Cover::kUnknown;
                m_leaves_told |= !ground && scene.cover[i] == Cover::kVegetation;
            }
        }
    }

    [[nodiscard]] Sighting find_asphalt() const {
        // Under the white balance that a camera may have; and what is taken for asphalt because it
        // is grey cannot say what grey is.
        constexpr float kGreyIfTold = 1.6F;
        constexpr float kGrey = 1.2F;
        constexpr float kUp = 0.989F;  // a slope of 0.15
        // Among grey ground that nothing tells apart are concrete and gravel, which are brighter.
        constexpr double kDarkShare = 0.2;
        Values values;
        each_lit([&](const Photographed& part, std::size_t i) {
            if (part.scene.kind[i] != Kind::kGround || part.slopes[i].up() < kUp ||
                (m_ground_told && find_cover(part, i) != Cover::kAsphalt))
                return;
            const Light albedo = albedo_at(part, i);
            if (is_grey(albedo, m_ground_told ? kGreyIfTold : kGrey))
                values.add(albedo);
        });
        const Sighting out = values.sighting(m_ground_told ? 0.5 : kDarkShare);
        return out.cells > 0 && is_coldest(out.albedo) ? out : Sighting{};
    }

    [[nodiscard]] Sighting find_leaves(const Light& grey) const {
        Values values;
        each_lit([&](const Photographed& part, std::size_t i) {
            const Kind kind = part.scene.kind[i];
            const bool crown = kind == Kind::kPlant &&
                               (!m_leaves_told || find_cover(part, i) == Cover::kVegetation);
            const bool open = kind == Kind::kGround && find_cover(part, i) != Cover::kAsphalt;
            const Light albedo = albedo_at(part, i);
            if ((crown || open) && is_leaf_green(balanced(albedo, grey)))
                values.add(albedo);
        });
        return values.sighting();
    }

    [[nodiscard]] Sighting find_tiles(const Light& grey) const {
        constexpr float kLeastUp = 0.64F;  // a slope of 1.2
        constexpr float kMostUp = 0.985F;  // 0.175
        constexpr float kMinFacing = 0.5F;
        Values values;
        each_lit([&](const Photographed& part, std::size_t i) {
            const Slope& slope = part.slopes[i];
            if (part.scene.kind[i] != Kind::kRoof || slope.up() < kLeastUp || slope.up() > kMostUp)
                return;
            const float facing = m_facing ? m_facing->on(slope) : 1;
            Light albedo = albedo_at(part, i);
            for (std::size_t c = 0; c < 3; ++c)
                albedo[c] /= m_light.sky[c] + (1 - m_light.sky[c]) * facing;
            if (facing >= kMinFacing && is_tile_red(balanced(albedo, grey)))
                values.add(albedo);
        });
        return values.sighting();
    }

    void find_darkest(Evidence& out) const {
        constexpr double kDarkest = 0.003;
        Values values;
        for (const Photographed& part : m_parts)
            each_shown(part, [&](std::size_t i) {
                values.add(albedo_at(part, i));
                ++out.cells;
            });
        if (out.cells > 0)
            out.darkest = values.at(kDarkest);
    }

private:
    /// Hardly anything is less red than asphalt is, whatever the white balance. Wet soil, which
    /// returns little light, too, is redder than much.
    [[nodiscard]] bool is_coldest(const Light& asphalt) const {
        constexpr double kFew = 0.1;
        constexpr float kRedder = 1.5F;
        std::vector<float> red_over_blue;
        each_lit([&](const Photographed& part, std::size_t i) {
            const Kind kind = part.scene.kind[i];
            const Light albedo = albedo_at(part, i);
            if (kind != Kind::kWater && kind != Kind::kUnknown && albedo[kBlue] > 0)
                red_over_blue.push_back(albedo[kRed] / albedo[kBlue]);
        });
        return asphalt[kRed] < kRedder * value_at(red_over_blue, kFew) * asphalt[kBlue];
    }

    template <class Visit>
    static void each_shown(const Photographed& part, const Visit& visit) {
        const Scene& scene = part.scene;
        for (int z = scene.margin; z < scene.height - scene.margin; ++z)
            for (int x = scene.margin; x < scene.width - scene.margin; ++x)
                if (const std::size_t i = scene.index(x, z); scene.shown[i] != 0)
                    visit(i);
    }

    template <class Visit>
    void each_lit(const Visit& visit) const {
        constexpr float kLit = 0.95F;
        for (const Photographed& part : m_parts)
            each_shown(part, [&](std::size_t i) {
                if (part.lit.empty() || part.lit[i] > kLit)
                    visit(part, i);
            });
    }

    static Cover find_cover(const Photographed& part, std::size_t i) noexcept {
        return part.scene.cover.empty() ? Cover::kUnknown : part.scene.cover[i];
    }

    /// Of flat ground in the sun.
    [[nodiscard]] Light albedo_at(const Photographed& part, std::size_t i) const noexcept {
        Light out = without_veil(part.scene.photo[i], m_light.veil);
        for (std::size_t c = 0; c < 3; ++c)
            out[c] *= m_light.gain[c];
        return out;
    }

    const FlightLight& m_light;
    std::vector<Photographed> m_parts;
    std::optional<Facing> m_facing;
    bool m_ground_told = false;
    bool m_leaves_told = false;
};

}  // namespace

Evidence find_evidence(std::span<const Scene> scenes, const FlightLight& light) {
    const KnownMaterials search(scenes, light);
    Evidence out;
    const auto seen = [&](Known material) -> Sighting& {
        return out.seen[static_cast<std::size_t>(material)];
    };
    const Sighting asphalt = search.find_asphalt();
    const Light grey = asphalt.cells >= kChance ? asphalt.albedo : Light{1, 1, 1};
    seen(Known::kAsphalt) = asphalt;
    seen(Known::kLeaves) = search.find_leaves(grey);
    seen(Known::kTiles) = search.find_tiles(grey);
    search.find_darkest(out);
    return out;
}

namespace {

struct Weighted {
    float value;
    std::uint64_t weight;
};

/// The least value that half of the weight does not exceed.
float weighted_median(std::vector<Weighted> values) {
    std::sort(values.begin(), values.end(), [](const Weighted& a, const Weighted& b) {
        return a.value < b.value || (a.value == b.value && a.weight < b.weight);
    });
    std::uint64_t total = 0;
    for (const Weighted& one : values)
        total += one.weight;
    std::uint64_t sum = 0;
    for (const Weighted& one : values) {
        sum += one.weight;
        if (2 * sum >= total)
            return one.value;
    }
    return 0;
}

/// @param of what is pooled of an Evidence: {Light, weight}
template <class Of>
Sighting pool(std::span<const Evidence> photographs, const Of& of) {
    Sighting out;
    std::array<std::vector<Weighted>, 3> values;
    for (const Evidence& one : photographs) {
        const Sighting seen = of(one);
        if (seen.cells == 0)
            continue;
        out.cells += seen.cells;
        for (std::size_t c = 0; c < 3; ++c)
            values[c].push_back({seen.albedo[c], seen.cells});
    }
    for (std::size_t c = 0; c < 3; ++c)
        out.albedo[c] = weighted_median(values[c]);
    return out;
}

}  // namespace

Evidence pooled(std::span<const Evidence> photographs) {
    Evidence out;
    for (std::size_t k = 0; k < kKnown; ++k)
        out.seen[k] = pool(photographs, [&](const Evidence& one) { return one.seen[k]; });
    const Sighting dark =
        pool(photographs, [](const Evidence& one) { return Sighting{one.darkest, one.cells}; });
    out.darkest = dark.albedo;
    out.cells = dark.cells;
    return out;
}

namespace {

/// Albedo in green light: a median of one place may be anything in between.
/// Ref: Herold, Roberts, Gardner, Dennison, "Spectrometry for urban area remote sensing", Remote
/// Sens. Environ. 91, 2004 (asphalt of all ages, clay tiles); the USGS spectral library, version 7
/// (leaves, grass).
struct Albedo {
    float low;
    float high;
    float usual;
};
constexpr std::array<Albedo, kKnown> kAlbedo{{
    {0.06F, 0.20F, 0.12F},  // asphalt
    {0.07F, 0.30F, 0.15F},  // leaves, needles and grass
    {0.15F, 0.35F, 0.24F},  // tiles
}};

/// The known materials in green light, less a black point.
class Verdicts {
public:
    Verdicts(const Evidence& evidence, const Light& black) {
        constexpr float kLeast = 1e-3F;
        for (std::size_t k = 0; k < kKnown; ++k) {
            if (evidence.seen[k].cells < kChance)
                continue;
            const float green = std::max(evidence.seen[k].albedo[kGreen] - black[kGreen], kLeast);
            m_possible.push_back(std::clamp(green, kAlbedo[k].low, kAlbedo[k].high) / green);
            m_usual.push_back(kAlbedo[k].usual / green);
        }
    }

    [[nodiscard]] bool is_enough() const noexcept { return m_usual.size() >= 2; }

    /// Whether most are as bright as they may be.
    [[nodiscard]] bool are_possible() const {
        constexpr float kHardly = 1.1F;
        const float needed = middle(m_possible);
        return needed * kHardly > 1 && needed < kHardly;
    }
    /// The factor that makes them as bright as usual.
    [[nodiscard]] float gain() const { return middle(m_usual); }

private:
    /// The median; of two the one nearer to 1, and 1 where they contradict each other.
    static float middle(std::vector<float> factors) {
        std::sort(factors.begin(), factors.end());
        if (factors.size() != 2)
            return factors[factors.size() / 2];
        return std::clamp(1.0F, factors[0], factors[1]);
    }

    std::vector<float> m_possible;
    std::vector<float> m_usual;
};

/// What lies in the deepest shadow, or behind a window, as a share of white.
constexpr float kDark = 0.02F;

float find_least(const Light& light) noexcept {
    return std::min({light[kRed], light[kGreen], light[kBlue]});
}

/// What is brighter than that everywhere. In one channel alone it is a colour, of grass say.
Light find_black(const Light& darkest, float gain) noexcept {
    constexpr float kMostOverLeast = 1.5F;
    const float most = kMostOverLeast * find_least(darkest);
    Light out{};
    for (std::size_t c = 0; c < 3; ++c)
        out[c] = std::max(std::min(darkest[c], most) - kDark / gain, 0.0F);
    return out;
}

/// What makes asphalt grey.
Light find_balance(const Sighting& asphalt, const Light& black) noexcept {
    constexpr float kMost = 2;
    Light out{1, 1, 1};
    if (asphalt.cells < kChance)
        return out;
    const Light seen = without_veil(asphalt.albedo, black);
    for (const std::size_t c : {kRed, kBlue})
        if (seen[c] > 0)
            out[c] = std::clamp(seen[kGreen] / seen[c], 1 / kMost, kMost);
    return out;
}

/// Whether asphalt is further from grey than its age and the sky make it.
bool has_cast(const Light& balance) noexcept {
    constexpr float kRedOrBlue = 1.25F;
    return std::max(balance[kRed], balance[kBlue]) > kRedOrBlue ||
           std::min(balance[kRed], balance[kBlue]) * kRedOrBlue < 1;
}

}  // namespace

Exposure find_exposure(const Evidence& evidence) {
    constexpr float kVeiled = 0.06F;  // nowhere is everything as bright as that
    constexpr int kRounds = 8;
    const Verdicts as_it_is(evidence, {});
    if (!as_it_is.is_enough())
        return {};
    Exposure out;
    float gain = 1;
    const bool wrong = !as_it_is.are_possible() || find_least(evidence.darkest) > kVeiled;
    // The black point and the gain depend on each other.
    for (int round = 0; wrong && round < kRounds; ++round) {
        gain = Verdicts(evidence, out.black).gain();
        out.black = find_black(evidence.darkest, gain);
    }
    const Light balance = find_balance(evidence.of(Known::kAsphalt), out.black);
    if (wrong || has_cast(balance))
        out.gain = {gain * balance[kRed], gain, gain * balance[kBlue]};
    return out;
}

FlightLight exposed(const FlightLight& light, const Exposure& exposure) {
    if (exposure == Exposure{})
        return light;
    constexpr float kLeastSky = 0.08F;
    FlightLight out = light;
    const float ground = light.typical[static_cast<std::size_t>(Kind::kGround)];
    for (std::size_t c = 0; c < 3; ++c) {
        const float black = exposure.black[c] / light.gain[c];
        out.veil[c] += black;
        out.gain[c] *= exposure.gain[c];
        // Shadow over sun, of ground that is less bright now by the same.
        if (light.sun && ground > 2 * black)
            out.sky[c] =
                std::clamp((light.sky[c] * ground - black) / (ground - black), kLeastSky, 1.0F);
    }
    const float dark = luminance(out.veil) - luminance(light.veil);
    for (float& typical : out.typical)
        typical = typical > 0 ? std::max(typical - dark, 0.0F) : typical;
    return out;
}

}  // namespace terravox::sunlight
