#include "voxelserver/data/imagery/band_roles.hpp"

#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "common/util/text.hpp"

namespace terravox::imagery {
namespace {

bool letter(char c) noexcept {
    return c >= 'a' && c <= 'z';
}

/// "irc" is a word of "ortho_irc1.tif", not of "circle.tif".
bool has_word(const std::string& text, std::initializer_list<std::string_view> words) {
    for (const std::string_view word : words)
        for (std::size_t at = text.find(word); at != std::string::npos;
             at = text.find(word, at + 1))
            if ((at == 0 || !letter(text[at - 1])) &&
                (at + word.size() == text.size() || !letter(text[at + word.size()])))
                return true;
    return false;
}

bool says_near_infrared(GDALRasterBand& band) {
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 10, 0)
    if (band.GetColorInterpretation() == GCI_NIRBand)
        return true;
#endif
    return has_word(util::lower_case(band.GetDescription()),
                    {"nir", "near infrared", "near-infrared", "near_infrared", "nearinfrared",
                     "infrared", "pir", "ir"});
}

bool says_longer_waves(const std::string& says) {
    return has_word(
        says, {"swir", "shortwave", "short-wave", "short wave", "mwir", "lwir", "tir", "thermal"});
}

bool says_anything_else(GDALRasterBand& band) {
    const GDALColorInterp meaning = band.GetColorInterpretation();
    return (meaning != GCI_Undefined && meaning != GCI_GrayIndex) ||
           std::string_view(band.GetDescription()) != "";
}

enum Colour : std::uint8_t { kRed, kGreen, kBlue, kNoColour };
constexpr std::array<const char*, 3> kColours = {"red", "green", "blue"};

/// What a description says.
struct Named {
    Colour colour = kNoColour;
    bool alone = false;  ///< nothing but the colour
};

Named find_named(const std::string& says) {
    // "red edge" and "coastal blue" are other bands of the same images.
    if (has_word(says, {"edge", "coastal", "aerosol"}))
        return {};
    constexpr std::array<std::string_view, 3> kLetters = {"r", "g", "b"};
    const std::array<bool, 3> has = {
        has_word(says, {"red", "rot", "rouge", "rood", "rojo", "rosso"}),
        has_word(says, {"green", "gr\xc3\xbcn", "gruen", "vert", "groen", "verde"}),
        has_word(says, {"blue", "blau", "bleu", "blauw", "azul", "blu"})};
    Named out;
    for (std::size_t c = 0; c < has.size(); ++c) {
        if (!has[c] && says != kLetters[c])
            continue;
        if (out.colour != kNoColour)
            return {};  // an index of two colours
        out = {static_cast<Colour>(c), says == kLetters[c] || says == kColours[c]};
    }
    return out;
}

/// The colours by the numbers that Sentinel-2 and Landsat 8 share. Older Landsats have other ones,
/// of which the first is blue.
std::vector<Named> find_numbered(const std::vector<std::string>& says) {
    const auto at = [&](std::string_view number) {
        return std::find_if(says.begin(), says.end(), [&](const std::string& s) {
            return s == "b0" + std::string(number) || s == "b" + std::string(number);
        });
    };
    const std::array found = {at("4"), at("3"), at("2")};
    std::vector<Named> out(says.size());
    const bool is_older = at("1") != says.end() && at("8") == says.end();
    if (is_older || std::find(found.begin(), found.end(), says.end()) != found.end())
        return out;
    for (std::size_t c = 0; c < found.size(); ++c)
        out[static_cast<std::size_t>(found[c] - says.begin())] = {static_cast<Colour>(c), true};
    return out;
}

Colour find_tagged(GDALRasterBand& band) {
    switch (band.GetColorInterpretation()) {
        case GCI_RedBand: return kRed;
        case GCI_GreenBand: return kGreen;
        case GCI_BlueBand: return kBlue;
        default: return kNoColour;
    }
}

/// What each band says of itself.
class Bands {
public:
    explicit Bands(GDALDataset& image) {
        for (int b = 1; b <= image.GetRasterCount(); ++b) {
            GDALRasterBand& band = *image.GetRasterBand(b);
            const bool infrared = says_near_infrared(band);
            m_says.push_back(util::lower_case(band.GetDescription()));
            m_named.push_back(infrared ? Named{} : find_named(m_says.back()));
            m_tagged.push_back(infrared ? kNoColour : find_tagged(band));
            m_shown.emplace_back(band.GetDescription());
            m_invisible.push_back(infrared || says_longer_waves(m_says.back()));
        }
        const auto is_named = [](const Named& n) { return n.colour != kNoColour; };
        if (std::none_of(m_named.begin(), m_named.end(), is_named))
            m_named = find_numbered(m_says);
    }

    /// By its description, or else by its colour interpretation; 0: none.
    [[nodiscard]] int find(Colour colour, std::string& doubt) const {
        std::vector<int> named;
        bool is_alone = false;
        for (std::size_t b = 0; b < m_named.size(); ++b) {
            if (m_named[b].colour != colour || (is_alone && !m_named[b].alone))
                continue;
            if (m_named[b].alone && !is_alone)
                named.clear();
            is_alone = is_alone || m_named[b].alone;
            named.push_back(static_cast<int>(b) + 1);
        }
        if (named.size() > 1)
            doubt = "bands " + std::to_string(named[0]) + " and " + std::to_string(named[1]) +
                    " are both named " + kColours[colour] + "; the first is taken";
        if (!named.empty())
            return named.front();
        for (std::size_t b = 0; b < m_tagged.size(); ++b)
            if (m_tagged[b] == colour && m_named[b].colour == kNoColour)
                return static_cast<int>(b) + 1;
        return 0;
    }

    /// A band whose description or colour interpretation says another colour than it is taken for,
    /// or light that nobody sees.
    void check(int band, Colour as, std::string& doubt) const {
        const auto i = static_cast<std::size_t>(band) - 1;
        if (band == 0 || !doubt.empty())
            return;
        const Colour named = m_named[i].colour;
        const Colour tagged = m_tagged[i];
        const std::string which = "band " + std::to_string(band) + " is ";
        const std::string taken = std::string("; it is taken for ") + kColours[as];
        if (m_invisible[i])
            doubt = which +
                    (m_shown[i].empty() ? "tagged near infrared" : "named '" + m_shown[i] + "'") +
                    taken;
        else if (named != kNoColour && named != as)
            doubt = which + "named '" + m_shown[i] + "'" + taken;
        else if (named != kNoColour && tagged != kNoColour && tagged != named)
            doubt = which + "named '" + m_shown[i] + "', but tagged " + kColours[tagged] + taken;
    }

private:
    std::vector<std::string> m_says;   ///< in lower case
    std::vector<std::string> m_shown;  ///< as the file has them
    std::vector<Named> m_named;
    std::vector<Colour> m_tagged;
    std::vector<bool> m_invisible;  ///< near infrared, or longer waves
};

BandRoles assign(GDALDataset& image, const std::string& name, const Bands& says,
                 std::string& doubt) {
    const int bands = image.GetRasterCount();
    BandRoles roles{says.find(kRed, doubt), says.find(kGreen, doubt), says.find(kBlue, doubt)};
    for (int b = bands; b >= 1; --b)
        if (says_near_infrared(*image.GetRasterBand(b)))
            roles.nir = b;
    // Described as near infrared, but tagged as if red, green, blue.
    if (roles.nir == 1 && roles.blue != 0 && bands == 3)
        roles = {2, 3, 0, 1, false};
    if (roles.nir != 0 && roles.red != 0 && roles.green != 0)
        return roles;
    if (bands >= 3 && has_word(name, {"irc", "cir"}))
        return {2, 3, 0, 1, false};
    if (bands < 3)
        return {1, 1, 1, 0, false};
    if (roles.red == 0 || roles.green == 0 || roles.blue == 0)
        roles = {1, 2, 3, roles.nir > 3 ? roles.nir : 0, false};
    if (roles.nir == 0 && bands >= 4 &&
        (has_word(name, {"rgbi", "rgbn", "rgbnir"}) ||
         !says_anything_else(*image.GetRasterBand(4))))
        roles.nir = 4;
    return roles;
}

}  // namespace

BandRoles find_roles(GDALDataset& image, const std::string& file_name) {
    if (image.GetRasterBand(1)->GetColorTable() != nullptr)
        return {1, 1, 1, 0, true};
    const Bands says(image);
    std::string doubt;
    BandRoles roles = assign(image, util::lower_case(file_name), says, doubt);
    if (roles.red == roles.green) {  // grey
        if (says_near_infrared(*image.GetRasterBand(1)))
            roles.doubt = "band 1 is near infrared alone; it is taken for grey";
        return roles;
    }
    says.check(roles.red, kRed, doubt);
    says.check(roles.green, kGreen, doubt);
    says.check(roles.blue, kBlue, doubt);
    roles.doubt = doubt;
    return roles;
}

}  // namespace terravox::imagery
