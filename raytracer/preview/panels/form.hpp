#pragma once

#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <variant>

#include "raytracer/scene/scene_fields.hpp"

namespace terravox::panels {

/// Rows of a panel, one for each field of a scene: its name, its value with its unit, and a way
/// back to what it was. What a field is called, where its range ends and what it is for comes from
/// the list of fields. Made anew for each frame.
class SceneForm {
public:
    /// @param usual what a reset goes back to; of the same world
    SceneForm(scene::Scene& scene, scene::Scene& usual);

    /// @param path "section.field" @return it has changed
    bool row(std::string_view path);
    /// The same with another range for the slider: what people mostly want. Numbers may be typed in
    /// beyond it, up to the field's own range.
    /// @param from where an own value begins, of a field that may have none; NaN: 0, or the range's
    /// end that is next to it
    bool row(std::string_view path, double low, double high,
             double from = std::numeric_limits<double>::quiet_NaN());
    /// Several, one below the other.
    bool rows(std::initializer_list<std::string_view> paths);

    /// What a person reads: "fov" and "deg".
    struct Label {
        std::string name, unit;
    };
    [[nodiscard]] static Label label_of(std::string_view path);

    /// What could not be set, and why; empty: nothing.
    [[nodiscard]] const std::string& problem() const noexcept { return m_problem; }

private:
    using Value =
        std::variant<double*, std::optional<double>*, int*, std::optional<int>*, bool*,
                     std::string*, std::optional<std::array<double, 3>>*, std::array<int, 2>*,
                     scene::TileSize*, core::CameraProjection*, core::CoordinateSpace*,
                     core::SkyModel*, core::ToneCurve*, core::PictureLayers*, core::TiffSamples*,
                     core::Integrator*, core::TileOrder*, core::VoxelColour*>;
    struct Field {
        Value value, usual;
        scene::FieldRule rule;
    };
    /// Of a slider, and where an own value begins.
    struct Range {
        double low, high, from;
    };
    class Row;
    bool draw(std::string_view path, Field& field, const Range& range);

    scene::Scene& m_scene;
    std::map<std::string_view, Field> m_fields;
    std::string m_problem;
};

}  // namespace terravox::panels
