// Writes a PNG with every texture of config/materials.toml: for each material 4 x 4 top faces, 4 x
// 4 side faces and the mips, four pixels a texel; and walls of houses by day and night with voxels
// of 1, 0.5, 0.25 and 2 m. Usage: texture_sheet OUT.png [night]
#include <cmath>
#include <cstdio>
#include <iterator>

#include "common/png/png.hpp"
#include "common/util/atomic_file.hpp"
#include "raytracer/material/material_table.hpp"

using namespace terravox;

namespace {

constexpr int kScale = 4;
constexpr int kFaces = 4;
constexpr int kBlock = kFaces * 16 * kScale;
constexpr int kGap = 8;
constexpr int kPanel = 2 * kBlock + 80 + 3 * kGap;
constexpr int kColumns = 3;

class Sheet {
public:
    Sheet(int width, int height)
        : m_width(width),
          m_height(height),
          m_bytes(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 40) {}
    void set(int x, int y, voxel::Colour c) {
        if (x < 0 || y < 0 || x >= m_width || y >= m_height)
            return;
        const std::size_t at = (static_cast<std::size_t>(y) * static_cast<std::size_t>(m_width) +
                                static_cast<std::size_t>(x)) *
                               3;
        m_bytes[at] = byte(c.r);
        m_bytes[at + 1] = byte(c.g);
        m_bytes[at + 2] = byte(c.b);
    }
    void write(const char* file) const {
        const std::string bytes = png::encode(m_bytes, {m_width, m_height, 3});
        util::write_file_atomically(file, std::as_bytes(std::span(bytes)));
    }

private:
    static std::uint8_t byte(float v) {
        return static_cast<std::uint8_t>(voxel::linear_to_srgb(v) * 255 + 0.5f);
    }
    int m_width;
    int m_height;
    std::vector<std::uint8_t> m_bytes;
};

voxel::Colour shown(const material::MaterialAppearance& appearance, const material::Texel& texel,
                    bool night) {
    const voxel::Colour base =
        appearance.colour * texel.ratio * (1 - texel.own_share) + texel.own * texel.own_share;
    const voxel::Colour behind{0.006f, 0.012f, 0.010f};
    return voxel::mix(behind, base * (night ? 0.04f : 1.0f), texel.opacity) +
           appearance.emission * (night ? texel.emission : 0.0f);
}

void faces(Sheet& sheet, const material::MaterialTable& table, voxel::Material material,
           core::Face face, int x0, int y0, bool night) {
    for (int y = 0; y < kBlock; ++y)
        for (int x = 0; x < kBlock; ++x) {
            const double s = (x + 0.5) / (16 * kScale);
            const double t = (kBlock - y - 0.5) / (16 * kScale);
            material::FacePoint at;
            at.face = face;
            const bool top = face == core::Face::kTop;
            const int i = static_cast<int>(s);
            const int j = static_cast<int>(t);
            at.voxel =
                top ? core::VoxelCoord{100 + i, 7, -30 - j} : core::VoxelCoord{100 + i, 7 + j, 4};
            at.u = top ? t - j : s - i;
            at.v = top ? s - i : t - j;
            // Half of the roofs rise to the upper edge, the others to the right, and one shows no
            // slope.
            at.around = i == 3 && j == 0 ? 0 : i < 2 ? 0b11100000 : 0b10010100;
            at.night = night;
            material::Texel texel = table.texel(material, at);
            const material::MaterialAppearance& appearance = table.appearance(material);
            if (appearance.kind == material::Kind::kWater)
                texel.ratio = texel.ratio * (1 + 12 * texel.tilt[0] + 7 * texel.tilt[1]);
            sheet.set(x0 + x, y0 + y, shown(appearance, texel, night));
        }
}

void mips(Sheet& sheet, const material::MaterialTable& table, voxel::Material material,
          core::Face face, int x0, int y0) {
    const auto& painted = table.painted(material, face);
    for (int mip = 0, at = 0; painted.variants > 0 && mip < material::kMips;
         at += 16 * kScale >> mip, ++mip)
        for (int y = 0; y < 16 * kScale >> mip; ++y)
            for (int x = 0; x < 16 * kScale >> mip; ++x) {
                const material::Dot dot = table.pool().dot(painted, 0, mip, x / kScale,
                                                           ((16 * kScale >> mip) - 1 - y) / kScale);
                const material::Texel texel{
                    dot.ratio, dot.own * table.appearance(voxel::Material::kSoil).colour,
                    dot.share, dot.opacity,
                    0,         0,
                    {}};
                sheet.set(x0 + x, y0 + at + y, shown(table.appearance(material), texel, false));
            }
}

void wall(Sheet& sheet, const material::MaterialTable& table, double voxel_m, int x0, int y0,
          int width, int height, bool night, double pixel_m) {
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double s = (x + 0.5) * pixel_m / voxel_m + 0.01;
            const double t = (height - y - 0.5) * pixel_m / voxel_m;
            material::FacePoint at;
            at.face = core::Face::kSouth;
            at.voxel_m = voxel_m;
            at.footprint = pixel_m / voxel_m;
            at.voxel = {static_cast<int>(s), static_cast<int>(t), 5};
            at.u = s - std::floor(s);
            at.v = t - std::floor(t);
            at.night = night;
            sheet.set(x0 + x, y0 + y,
                      shown(table.appearance(voxel::Material::kWall),
                            table.texel(voxel::Material::kWall, at), night));
        }
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) {
        std::fputs("usage: texture_sheet OUT.png [night]\n", stderr);
        return 2;
    }
    const bool night = count > 2;
    const material::MaterialTable table(std::filesystem::path(TERRAVOX_SOURCE_DIR) /
                                        "config/materials.toml");
    constexpr int kRows = (voxel::kMaterialCount + kColumns - 1) / kColumns;
    constexpr int kRowHeight = kBlock + kGap;
    constexpr int kWalls = 620;
    Sheet sheet(kColumns * kPanel, kRows * kRowHeight + kWalls);
    for (int i = 1; i < voxel::kMaterialCount; ++i) {
        const auto material = static_cast<voxel::Material>(i);
        const int x0 = (i - 1) % kColumns * kPanel;
        const int y0 = (i - 1) / kColumns * kRowHeight;
        faces(sheet, table, material, core::Face::kTop, x0, y0, night);
        faces(sheet, table, material, core::Face::kSouth, x0 + kBlock + kGap, y0, night);
        mips(sheet, table, material, core::Face::kSouth, x0 + 2 * (kBlock + kGap), y0);
    }
    const int y0 = kRows * kRowHeight;
    const int width = kColumns * kPanel / 4 - kGap;
    constexpr std::array kVoxel_m = {1.0, 0.5, 0.25, 2.0};
    for (int i = 0; i < 4; ++i) {
        wall(sheet, table, kVoxel_m[static_cast<std::size_t>(i)], i * (width + kGap), y0, width,
             300, night, 1.0 / 32);
        wall(sheet, table, kVoxel_m[static_cast<std::size_t>(i)], i * (width + kGap), y0 + 308,
             width, 300, night, 1.0 / (i < 2 ? 8 : 3));
    }
    sheet.write(arguments[1]);
}
