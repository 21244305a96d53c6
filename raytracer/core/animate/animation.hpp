#pragma once

#include <toml++/toml.h>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "raytracer/core/scene/scene.hpp"

namespace terravox::animate {

/// A number that moves smoothly through given ones: piecewise cubic with a continuous first
/// derivative. Constant before the first and after the last. Immutable.
class SmoothPath {
public:
    enum class Kind : bool {
        kRound,     ///< for positions: round bends, which may overshoot
        kMonotone,  ///< never beyond the two neighbouring numbers
    };
    /// @param times ascending, seconds
    /// @param values as many as `times`, at least one
    /// @param at_rest whether the rate is 0 at both ends; otherwise it is that of the first and
    /// last segment
    SmoothPath(std::vector<double> times, std::vector<double> values, Kind kind, bool at_rest);
    [[nodiscard]] double at(double time) const noexcept;

private:
    std::vector<double> m_times;
    std::vector<double> m_values;
    std::vector<double> m_rates;
};

/// A sequence of pictures described by a TOML file: a pure function of the file, the underlying
/// scene and the frame number.
///
/// The file: `fps` (25), `seconds`, `ease` (true: movement begins and ends at rest), [[key]] tables
/// with `time_s` or `frame` and fields of a scene (or camera.look: all fields of a named view),
/// [turntable] with `turns`, `seconds`, `target`, [day] with `from`, `to` (clock hours), `seconds`;
/// and sections of a scene, which all frames share. Numbers move along smooth paths and never
/// beyond the values of the surrounding keys; camera.position and camera.target move along round
/// paths. Whole numbers, words and switches change at their key. Before a field's first key and
/// after its last one, the field keeps that key's value.
class Animation {
public:
    /// @param views folder of named views; empty: config/views
    /// @throws UsageError naming file, key and field
    [[nodiscard]] static Animation read(const std::filesystem::path& file,
                                        const std::filesystem::path& views = {});
    /// The same for a text.
    /// @param name used in messages
    [[nodiscard]] static Animation parse(const std::string& text, const std::string& name,
                                         const std::filesystem::path& views = {});

    /// Applies the settings that all frames share to `scene`.
    void apply_base(scene::Scene& scene) const;
    [[nodiscard]] int frames() const noexcept { return m_frames; }
    [[nodiscard]] double fps() const noexcept { return m_fps; }
    /// @param frame [0, frames())
    /// @param base the scene that keys, turntable and day modify
    /// @throws UsageError when `base` does not fit the file
    [[nodiscard]] scene::Scene at(int frame, const scene::Scene& base) const;

    static constexpr int kMaxFrames = 1'000'000;

private:
    friend class AnimationReader;
    using Word = std::variant<int, bool, std::string>;
    /// One field over time; exactly one of the three is filled.
    struct Track {
        std::vector<SmoothPath> paths;  ///< one, or three for a triple
        std::vector<double> times;
        std::vector<Word> words;
    };
    struct Turntable {
        double turns = 1;
        double seconds = 0;
        std::optional<std::array<double, 3>> target;
    };
    struct Day {
        double from = 0;
        double to = 24;
        double seconds = 0;
    };
    void turn(scene::Scene& scene, double time_s) const;
    [[nodiscard]] static const Word& word_at(const Track& track, double time_s);

    std::string m_attempt;  ///< begins every message
    toml::table m_base;
    double m_fps = 25;
    int m_frames = 0;
    std::map<std::string, Track, std::less<>> m_tracks;
    std::optional<Turntable> m_turntable;
    std::optional<Day> m_day;
};

}  // namespace terravox::animate
