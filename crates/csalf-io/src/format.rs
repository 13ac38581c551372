//! Which formats there are, and which one a file name means.

use crate::IoError;
use std::path::Path;

/// Makes a format enum with its names and extensions.
macro_rules! formats {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $label:literal, [$($ext:literal),*];)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum $name {
            $($(#[$vdoc])* $variant,)*
        }

        impl $name {
            /// All formats, in the order in which they are listed to people.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Short name, as a caller gives it for standard input and output.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $label,)* }
            }

            /// File name extensions in lower case, the usual one first.
            pub const fn extensions(self) -> &'static [&'static str] {
                match self { $(Self::$variant => &[$($ext),*],)* }
            }

            /// The format of this short name or extension, in any case of letters.
            pub fn from_name(name: &str) -> Option<Self> {
                let name = name.to_ascii_lowercase();
                let by_label = Self::ALL.iter().find(|f| f.name() == name);
                by_label.or_else(|| Self::ALL.iter().find(|f| f.extensions().contains(&name.as_str()))).copied()
            }

            /// The format that the extension of `path` means.
            ///
            /// # Errors
            /// [`IoError::UnknownFormat`] if the extension is missing or unknown.
            pub fn from_path(path: &Path) -> Result<Self, IoError> {
                let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
                Self::ALL.iter().find(|f| f.extensions().contains(&extension.as_str())).copied().ok_or_else(|| {
                    let known: Vec<String> =
                        Self::ALL.iter().flat_map(|f| f.extensions()).map(|e| format!(".{e}")).collect();
                    IoError::UnknownFormat { extension, known: known.join(", ") }
                })
            }
        }
    };
}

formats! {
    /// Formats of meshes and pictures.
    MeshFormat {
        /// VTK XML unstructured grid. Read and written.
        Vtu = "vtu", ["vtu"];
        /// Gmsh 4.1, ASCII. Read (also binary) and written.
        Msh41 = "msh41", ["msh"];
        /// Gmsh 2.2, ASCII. Read (also binary) and written.
        Msh22 = "msh22", ["msh2"];
        /// Abaqus and CalculiX input. Read and written.
        Inp = "inp", ["inp"];
        /// Nastran bulk data. Read and written.
        Bdf = "bdf", ["bdf", "nas", "fem"];
        /// Wavefront OBJ. Read and written.
        Obj = "obj", ["obj"];
        /// Exodus II. Written only.
        Exodus = "exodus", ["exo", "e", "ex2"];
        /// I-DEAS universal file. Written only.
        Unv = "unv", ["unv"];
        /// SU2. Written only.
        Su2 = "su2", ["su2"];
        /// OpenFOAM case, one cell thick: a folder beside the file. Written only.
        Foam = "foam", ["foam"];
        /// VTKHDF unstructured grid. Written only.
        VtkHdf = "vtkhdf", ["vtkhdf", "hdf"];
        /// ISM-v2 of HOHQMesh, for spectral elements. Written only.
        Ism = "ism", ["mesh"];
        /// Picture, vectors. Written only.
        Svg = "svg", ["svg"];
        /// Picture, pixels. Written only.
        Png = "png", ["png"];
    }
}

formats! {
    /// Formats of meshing jobs and outlines.
    JobFormat {
        /// The program's own job format.
        Json = "json", ["json"];
        /// GeoJSON polygons.
        GeoJson = "geojson", ["geojson"];
        /// TopoJSON polygons.
        TopoJson = "topojson", ["topojson"];
        /// Outline of Shewchuk's Triangle.
        Poly = "poly", ["poly"];
        /// Drawing.
        Dxf = "dxf", ["dxf"];
        /// Paths of a picture.
        Svg = "svg", ["svg"];
        /// Gmsh line elements.
        Msh = "msh", ["msh"];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_by_name_and_by_extension() {
        assert_eq!(MeshFormat::from_name("MSH22"), Some(MeshFormat::Msh22));
        assert_eq!(MeshFormat::from_name("nas"), Some(MeshFormat::Bdf));
        assert_eq!(MeshFormat::from_name("msh"), Some(MeshFormat::Msh41));
        assert_eq!(MeshFormat::from_name("zip"), None);
        assert_eq!(JobFormat::from_path(Path::new("a/b.c/part.DXF")).ok(), Some(JobFormat::Dxf));
        let e = MeshFormat::from_path(Path::new("mesh")).unwrap_err().to_string();
        assert!(e.contains(".vtu, .msh, .msh2"), "{e}");
    }
}
