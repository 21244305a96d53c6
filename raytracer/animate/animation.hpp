#pragma once

#include <toml++/toml.h>

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "raytracer/animate/smooth_path.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::animate {

/// Pictures in a row, out of a TOML file: a pure function of the file, the scene underneath and the
/// number of the frame.
///
/// The file: `fps` (25), `seconds`, `ease` (true: movement begins and ends at rest), [[key]] tables
/// with `time_s` or `frame` and fields of a scene (or camera.look: all that a named view says),
/// [turntable] with `turns`, `seconds`, `target`, [day] with `from`, `to` (clock hours), `seconds`;
/// and sections of a scene, which all frames share. Numbers move along smooth paths and never
/// beyond what the keys around say, camera.position and camera.target along round ones; whole
/// numbers, words and switches change at their key. Before a field's first key and after its last
/// one it keeps that key's value.
class Animation {
public:
    /// @param views folder of named views; empty: config/views @throws UsageError naming file, key
    /// and field
    [[nodiscard]] static Animation read(const std::filesystem::path& file,
                                        const std::filesystem::path& views = {});
    /// The same of a text that came another way. @param name for messages
    [[nodiscard]] static Animation parse(const std::string& text, const std::string& name,
                                         const std::filesystem::path& views = {});

    /// What the file says of all frames, over `scene`.
    void apply_base(scene::Scene& scene) const;
    [[nodiscard]] int frames() const noexcept { return m_frames; }
    [[nodiscard]] double fps() const noexcept { return m_fps; }
    /// @param frame [0, frames()) @param base what keys, turntable and day change @throws
    /// UsageError when `base` does not fit the file
    [[nodiscard]] scene::Scene at(int frame, const scene::Scene& base) const;

    static constexpr int kMaxFrames = 1'000'000;

private:
    friend class AnimationReader;
    using Word = std::variant<int, bool, std::string>;
    /// One field over time; one of the three is filled.
    struct Track {
        std::vector<SmoothPath> paths;  ///< one, or three for a triple
        std::vector<double> times;
        std::vector<Word> words;
    };
    struct Turntable {
        double turns = 1, seconds = 0;
        std::optional<std::array<double, 3>> target;
    };
    struct Day {
        double from = 0, to = 24, seconds = 0;
    };
    void turn(scene::Scene& scene, double time_s) const;
    [[nodiscard]] static const Word& word_at(const Track& track, double time_s);

    std::string m_attempt;  ///< begins messages
    toml::table m_base;
    double m_fps = 25;
    int m_frames = 0;
    std::map<std::string, Track, std::less<>> m_tracks;
    std::optional<Turntable> m_turntable;
    std::optional<Day> m_day;
};

}  // namespace terravox::animate
