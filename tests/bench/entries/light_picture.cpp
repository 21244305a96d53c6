#include "tests/bench/entries/light_picture.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "common/util/error.hpp"
#include "raytracer/processors/thread_processor.hpp"

namespace terravox::bench {

LinearPicture picture_of(const output::Film& film) {
    LinearPicture out{film.width_px(), film.height_px(), {}};
    out.rgb.reserve(film.samples().size() * 3);
    for (const tiles::PixelSample& pixel : film.samples())
        out.rgb.insert(out.rgb.end(), {pixel.colour.r, pixel.colour.g, pixel.colour.b});
    return out;
}

LinearPicture read_picture(const std::filesystem::path& path, int width_px, int height_px) {
    LinearPicture out{width_px, height_px, {}};
    out.rgb.resize(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) * 3);
    std::ifstream file(path, std::ios::binary);
    const auto bytes = static_cast<std::streamsize>(out.rgb.size() * sizeof(float));
    if (!file.read(reinterpret_cast<char*>(out.rgb.data()), bytes) ||
        file.peek() != std::ifstream::traits_type::eof())
        throw util::Error("read the picture " + path.string() + ": not " +
                          std::to_string(width_px) + " x " + std::to_string(height_px) +
                          " x 3 numbers");
    if (!std::all_of(out.rgb.begin(), out.rgb.end(), [](float v) { return std::isfinite(v); }))
        throw util::Error("read the picture " + path.string() + ": a number is not finite");
    return out;
}

void write_picture(const std::filesystem::path& path, const LinearPicture& picture) {
    std::ofstream file(path, std::ios::binary);
    if (!file.write(reinterpret_cast<const char*>(picture.rgb.data()),
                    static_cast<std::streamsize>(picture.rgb.size() * sizeof(float)))
             .flush())
        throw util::Error("write the picture " + path.string());
}

double mean_of(const LinearPicture& picture) noexcept {
    double sum = 0;
    for (const float v : picture.rgb)
        sum += static_cast<double>(v);
    return sum / static_cast<double>(std::max<std::size_t>(picture.rgb.size(), 1));
}

double rms_difference(const LinearPicture& a, const LinearPicture& b) {
    if (a.rgb.size() != b.rgb.size() || a.rgb.empty())
        throw util::Error("compare pictures: of " + std::to_string(a.rgb.size()) + " and " +
                          std::to_string(b.rgb.size()) + " numbers");
    double sum = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) {
        const double d = static_cast<double>(a.rgb[i]) - static_cast<double>(b.rgb[i]);
        sum += d * d;
    }
    return std::sqrt(sum / static_cast<double>(a.rgb.size()));
}

double noise_of(const LinearPicture& one, const LinearPicture& other) {
    return rms_difference(one, other) / std::numbers::sqrt2;
}

TracedPicture trace_picture(const shade::View& view, blocks::BlockManager& blocks, int threads) {
    const auto [width, height] = view.scene.output.size_px;
    output::Film film(width, height);
    TracedPicture out;
    out.cost = cost_of([&] {
        processors::ThreadProcessor processor(view, blocks, threads);
        out.counts = render::render_film({view, processor, true, {}}, film);
    });
    if (out.counts.trace.hole_rays != 0)
        throw util::Error("trace a picture: " + std::to_string(out.counts.trace.hole_rays) +
                          " rays met holes");
    out.picture = picture_of(film);
    return out;
}

std::shared_ptr<const material::MaterialTable> grey_materials(float albedo) {
    material::MaterialAppearance grey;
    grey.colour = {albedo, albedo, albedo};
    material::MaterialAppearances appearances;
    appearances.fill(grey);
    return std::make_shared<material::MaterialTable>(appearances);
}

void set_sun(scene::Scene& scene, core::Vec3 to_sun) {
    constexpr double kDegrees = 180 / std::numbers::pi;
    scene.sun.altitude_deg = std::asin(std::clamp(to_sun.y, -1.0, 1.0)) * kDegrees;
    scene.sun.azimuth_deg = std::atan2(to_sun.x, -to_sun.z) * kDegrees;
}

std::string light_script(const std::string& file) {
    return std::string(TERRAVOX_SOURCE_DIR) + "/tests/bench/light/" + file;
}

nlohmann::json figures_of(const Context& context, const std::vector<std::string>& command,
                          const std::filesystem::path& figures) {
    const auto said = context.scratch / (figures.stem().string() + ".txt");
    const std::string attempt = "run " + command.front();
    const ChildOutcome outcome = context.children.run(command, said);
    if (outcome.exit_code != 0)
        throw util::Error(attempt + ": exit code " + std::to_string(outcome.exit_code) + ": " +
                          last_line(said));
    std::ifstream file(figures);
    nlohmann::json out = nlohmann::json::parse(file, nullptr, false);
    if (!out.is_object())
        throw util::Error(attempt + ": no figures in " + figures.string() + ": " + last_line(said));
    return out;
}

}  // namespace terravox::bench
