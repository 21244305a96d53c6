// Renders any world into a PPM picture:
//   render_a_picture place.laz picture.ppm
#include <terravox/terravox.hpp>

#include <cstdio>
#include <fstream>

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: render_a_picture WORLD PICTURE.ppm\n");
        return 2;
    }
    try {
        const auto world = terravox::World::open({argv[1]});
        terravox::SceneText scene;
        scene.fields = {{"output.size", "640x360"}, {"sun.time_h", "17"}};
        const terravox::Picture picture = world.render(scene);

        std::ofstream file(argv[2], std::ios::binary);
        file << "P6\n" << picture.width << " " << picture.height << "\n255\n";
        file.write(reinterpret_cast<const char*>(picture.rgb.data()),
                   static_cast<std::streamsize>(picture.rgb.size()));
        std::printf("%s: %zu x %zu pixels\n", world.info().title.c_str(), picture.width,
                    picture.height);
        return file.flush() ? 0 : 1;
    } catch (const terravox::Error& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
}
