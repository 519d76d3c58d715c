// The commands that Python code carries out. Their options are described here, for help, completion and the manual;
// src/python/pliant reads them.
#include "command/command_help.hpp"
#include "command/command_line.hpp"
#include "command/python_command.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <utility>

namespace pliant {
namespace {

/// An option whose value is not read here.
struct PythonOption {
  const char* names;
  const char* type;
  const char* what;
  bool repeats = false;
};

void add(CLI::App& to, const std::vector<PythonOption>& options) {
  for (const PythonOption& option : options) {
    auto* added = to.add_option(option.names)->description(option.what)->type_name(option.type);
    added->expected(1, option.repeats ? CLI::detail::expected_max_vector_size : 1)->allow_extra_args(false);
    if (!option.repeats) added->take_last();
  }
}

}  // namespace

CLI::App& CommandLine::add_in_python(const char* name, const char* what, const PythonArgument& argument) {
  CLI::App* command = app_.add_subcommand(name, what);
  command->add_option(argument.name)->description(argument.what)->required();
  command->callback([this, name] {
    command_ = [this, name] {
      if (num_ranks(comm_) > 1) {
        throw InputError({std::string("pliant ") + name, 0, 0}, "start it without mpirun");
      }
      const auto after = std::ranges::find(words_, std::string(name)) + 1;
      result_ = python_command(name, {after, words_.end()}, arguments_.sweep.environment);
    };
  });
  return *command;
}

void CommandLine::add_render() {
  CLI::App& render = add_in_python("render", "draw a result as pictures, a movie or a 3D model",
                                   {"RESULT", "the output directory of a run, its result.xdmf or its result.h5"});
  render.footer(examples({"pliant render out/beam", "pliant render out/beam --field von_mises_stress --movie mp4",
                          "pliant render out/beam --frame 10 --view=-1,0.5,0.3 --hide floor --output beam.png",
                          "pliant render out/finger --cut y --mesh-edges --colour-map cividis",
                          "pliant render out/beam --field von_mises_stress --output beam.glb"}));
  add(render,
      {{"-o,--output", "FILE",
        "file to write (with --frames: directory), a picture, or all frames as a 3D model (.glb); default: in the "
        "output directory"},
       {"--field", "FIELD",
        "what colours the body: displacement (default), velocity, von_mises_stress, velocity_z, cauchy_stress_xx, "
        "body, "
        "rank, ..., tension (colours tendons and springs), or none"},
       {"--range", "LOW,HIGH", "of the colours, in SI units; default: that of all frames"},
       {"--colour-map", "auto|viridis|cividis|inferno|greys|diverging",
        "viridis; cividis, the same for every colour vision; inferno; greys; diverging: blue to red about 0; default: "
        "auto, diverging for values of both signs, else viridis"},
       {"--movie", "mp4|gif|glb", "write a movie of all frames, or a 3D model that moves (.glb)"},
       {"--fps", "N", "frames per second of the movie (25); of a .glb, which otherwise plays in real time"},
       {"--frame", "N", "which frame to draw, from 0; -1 or last is the last (default: last)"},
       {"--view", "iso|front|back|right|left|top|bottom",
        "where the viewer stands, seen from the body: a direction X,Y,Z or one of iso, front, back, right, left, top, "
        "bottom (iso)"},
       {"--size", "WxH", "in pixels (1280x800)"},
       {"--scale", "FACTOR",
        "displacements are multiplied by it (1); obstacles, tendons, springs and joints are drawn at 1 only"},
       {"--cut", "PLANE",
        "take away what the undeformed bodies have on the viewer's side of a plane: y (through their middle), y=0.01, "
        "or "
        "NORMAL=OFFSET such as 1,0,1=0.02 [m]"},
       {"--mirror", "PLANE",
        "draw the bodies of half a model and their image at x=0 (x), or at a plane such as y=0.01; may be repeated",
        true},
       {"--hide", "NAME", "leave out a body, an obstacle, a tendon, a spring or a joint; may be repeated", true},
       {"--transparent", "NAME", "draw a body or an obstacle transparent; may be repeated", true},
       {"--title", "TEXT", "instead of the run's title"}});
  for (const auto& [name, what] : {std::pair{"--frames", "write every frame as a PNG"},
                                   std::pair{"--mesh-edges", "draw the edges of the elements"},
                                   std::pair{"--outline", "draw the edges of the undeformed shape"},
                                   std::pair{"--no-axes", "leave out the axes and the scale bar"}}) {
    render.add_flag(name)->description(what);
  }
}

void CommandLine::add_plot() {
  CLI::App& plot =
      add_in_python("plot", "draw the history of a run: energies, probes, forces, cavities, joints, iterations",
                    {"RUN", "the output directory of a run, or its history.csv"});
  plot.footer(examples({"pliant plot out/beam", "pliant plot out/beam --output beam.pdf",
                        "pliant plot out/finger --of chamber_pressure --x chamber_volume"}));
  add(plot, {{"-o,--output", "FILE", "file to write (.png, .pdf, .svg); default: history.png in the output directory"},
             {"--of", "COLUMN,...", "columns of the history to draw instead; those of one unit together", true},
             {"--x", "COLUMN",
              "the column to draw those over, instead of time: pressure over volume, force over displacement"}});
}

void CommandLine::add_convert() {
  CLI::App& convert =
      add_in_python("convert", "write an input from a model of Abaqus, CalculiX (.inp) or FEBio (.feb)",
                    {"MODEL", "an input file of Abaqus or CalculiX (.inp), or a model of FEBio (.feb)"});
  convert.footer(examples({"pliant convert beam.inp", "pliant convert knee.feb --units mm-N-s --output knee.yaml"}));
  add(convert,
      {{"-o,--output", "INPUT.yaml",
        "the input to write, with its mesh (.msh) next to it; default: MODEL.yaml in the working directory"},
       {"--units", "SI|mm-N-s|mm-kg-s|mm-g-s|mm-mg-s|mm-kg-ms|um-nN-s|CGS",
        "the units of the model, from which all numbers are converted to SI; default: those that the file names, else "
        "its numbers are kept as they are"}});
  convert.add_flag("--force")->description("replace files that exist");
}

}  // namespace pliant
