#include <cmath>
#include <functional>
#include <map>

#include "raytracer/core/material/texture_list.hpp"
#include "raytracer/core/material/texture_pool.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::material;

namespace {

struct Face3 {
    const char* name;
    Drawing Texture::* face;
};
constexpr std::array kFaces = {Face3{"top", &Texture::top}, Face3{"side", &Texture::side},
                               Face3{"bottom", &Texture::bottom}};

// check(name, painted face, pool) for every drawing of every texture.
void for_all(
    const std::function<void(const std::string&, const PaintedFace&, const TexturePool&)>& check) {
    for (const Texture& texture : textures())
        for (const auto& [name, face] : kFaces) {
            TexturePool pool;
            const PaintedFace painted = pool.add(texture.*face);
            if (painted.variants > 0)
                check(std::string(texture.name) + " " + name, painted, pool);
        }
}

// Sums over a mip of a variant: what is seen of the voxel's colour, and of the texture's own.
struct Sums {
    double ratio[3] = {}, own[3] = {}, ratio_weight = 0, own_weight = 0, opacity = 0;
};
Sums sums(const TexturePool& pool, const PaintedFace& face, std::uint32_t variant, int mip) {
    const int size = kTexels >> mip;
    Sums out;
    for (int t = 0; t < size; ++t)
        for (int s = 0; s < size; ++s) {
            const Dot dot = pool.dot(face, variant, mip, s, t);
            const double share = 1.0 / (size * size);
            const double own = static_cast<double>(dot.opacity * dot.share) * share;
            const double rest = static_cast<double>(dot.opacity) * share - own;
            const float c[3] = {dot.ratio.r, dot.ratio.g, dot.ratio.b},
                        o[3] = {dot.own.r, dot.own.g, dot.own.b};
            for (int i = 0; i < 3; ++i) {
                out.ratio[i] += static_cast<double>(c[i]) * rest;
                out.own[i] += static_cast<double>(o[i]) * own;
            }
            out.ratio_weight += rest;
            out.own_weight += own;
            out.opacity += static_cast<double>(dot.opacity) * share;
        }
    return out;
}

}  // namespace

TEST_CASE("every texture has a name that leads back to it", "[raytracer][material]") {
    int number = 0;
    for (const Texture& texture : textures())
        CHECK(texture_number(texture.name) == number++);
    CHECK(texture_number("none") == 0);
    CHECK(texture_number("marble") == -1);
    CHECK(texture_number("") == -1);
}

TEST_CASE("the mean ratio of every variant and mip is 1, so that distance changes no colour",
          "[raytracer][material]") {
    for_all([](const std::string& name, const PaintedFace& face, const TexturePool& pool) {
        for (std::uint32_t v = 0; v < face.variants; ++v)
            for (int mip = 0; mip < kMips; ++mip) {
                INFO(name << ", variant " << v << ", mip " << mip);
                const Sums here = sums(pool, face, v, mip);
                for (const double channel : here.ratio)
                    CHECK(std::abs(channel / here.ratio_weight - 1) < 1e-3);
                if (here.own_weight > 0)
                    for (const double channel : here.own)
                        CHECK(std::abs(channel / here.own_weight - 1) < 1e-3);
            }
    });
}

TEST_CASE("mips show as much light, own colour and holes as the texels do",
          "[raytracer][material]") {
    for_all([](const std::string& name, const PaintedFace& face, const TexturePool& pool) {
        for (std::uint32_t v = 0; v < face.variants; ++v) {
            const Sums fine = sums(pool, face, v, 0);
            for (int mip = 1; mip < kMips; ++mip) {
                INFO(name << ", variant " << v << ", mip " << mip);
                const Sums coarse = sums(pool, face, v, mip);
                CHECK(std::abs(coarse.opacity - fine.opacity) < 1e-3);
                CHECK(std::abs(coarse.own_weight - fine.own_weight) < 1e-3);
                for (int i = 0; i < 3; ++i) {
                    CHECK(std::abs(coarse.ratio[i] - fine.ratio[i]) < 1e-3);
                    CHECK(std::abs(coarse.own[i] - fine.own[i]) < 1e-3);
                }
            }
        }
    });
}

TEST_CASE("textures are drawn with the same bits every time", "[raytracer][material]") {
    std::uint64_t first = 0;
    for (int run = 0; run < 2; ++run) {
        std::uint64_t sum = 0xcbf29ce484222325;  // Ref: Fowler, Noll, Vo, FNV-1a
        for_all([&](const std::string&, const PaintedFace& face, const TexturePool& pool) {
            for (std::uint32_t v = 0; v < face.variants; ++v)
                for (int t = 0; t < kTexels; ++t)
                    for (int s = 0; s < kTexels; ++s) {
                        const Dot dot = pool.dot(face, v, 0, s, t);
                        for (const float c : {dot.ratio.r, dot.ratio.g, dot.ratio.b, dot.own.r,
                                              dot.own.g, dot.own.b, dot.opacity, dot.share})
                            sum = (sum ^ std::bit_cast<std::uint32_t>(c)) * 0x100000001b3;
                    }
        });
        if (run == 0)
            first = sum;
        else
            CHECK(sum == first);
    }
}

TEST_CASE("between two mips a texture is their mixture", "[raytracer][material]") {
    constexpr float kCoarse = 0.25f;
    for_all([&](const std::string& name, const PaintedFace& face, const TexturePool& pool) {
        INFO(name);
        const Dot fine = pool.dot(face, 0, 0, 6, 10);
        const Dot coarse = pool.dot(face, 0, 1, 3, 5);
        Texel found;
        pool.look_up(face, {0, 0, 6.5f / kTexels, 10.5f / kTexels, {0, kCoarse}}, found);
        CHECK(found.ratio.g == Approx(fine.ratio.g * (1 - kCoarse) + coarse.ratio.g * kCoarse));
        CHECK(found.opacity == Approx(fine.opacity * (1 - kCoarse) + coarse.opacity * kCoarse));
    });
}
